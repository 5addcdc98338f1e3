"""A server that answers as mwidthd does: an elbow that follows minimum-jerk reaches exactly, whatever the mass.

Its force is that of an ideal rendering, M x'', so that the perceived mass is m + M. Time is counted in ticks, and
samples flow as fast as they are read.
"""

import concurrent.futures
import math
import threading

import grpc
import numpy as np
from google.rpc import error_details_pb2, status_pb2

from mwidth.v1 import rendering_pb2 as rendering
from mwidth.v1 import rendering_pb2_grpc, stability_pb2, stability_pb2_grpc, telemetry_pb2, telemetry_pb2_grpc

PERIOD_S = 0.001
DEVICE_MASS = 0.05
DEVICE_DAMPING = 0.1
NOMINAL = (-0.045, 0.5)
ADMITTED = (-0.03, 0.35)
MAX_CUTOFF_HZ = 40
REACH_S = 0.8
HOLD_S = 1.2
AMPLITUDE_RAD = math.radians(30)


def minimum_jerk(time_s):
    """Position, velocity and acceleration of the endless reach at times (s) since the start."""
    phase = np.mod(time_s, 2 * (HOLD_S + REACH_S))
    back = phase >= HOLD_S + REACH_S
    u = np.clip((np.where(back, phase - HOLD_S - REACH_S, phase) - HOLD_S) / REACH_S, 0, 1)
    sign = np.where(back, -1, 1)
    position = AMPLITUDE_RAD * (back + sign * (10 * u**3 - 15 * u**4 + 6 * u**5))
    velocity = AMPLITUDE_RAD / REACH_S * sign * (30 * u**2 - 60 * u**3 + 30 * u**4)
    acceleration = AMPLITUDE_RAD / REACH_S**2 * sign * (60 * u - 180 * u**2 + 120 * u**3)
    return position, velocity, acceleration


def loop():
    return stability_pb2.LoopParameters(
        device_mass=DEVICE_MASS,
        device_damping=DEVICE_DAMPING,
        hand_mass=0,
        hand_damping=0.5,
        hand_stiffness=20,
        period_s=PERIOD_S,
        cutoff_hz=10,
        delay_s=0,
        estimator=stability_pb2.ESTIMATOR_KIND_FILTERED_DIFFERENCE,
    )


def m_width():
    width = stability_pb2.MWidth(required_gain_margin_db=3)
    width.nominal.min, width.nominal.max = NOMINAL
    width.robust.CopyFrom(width.nominal)
    width.admitted.min, width.admitted.max = ADMITTED
    return width


def analysed(request):
    """The loop with the overrides of a request."""
    merged = loop()
    merged.MergeFrom(request.loop)
    return merged


def stability_report(mass):
    edge = NOMINAL[0] if mass < 0 else NOMINAL[1]
    return stability_pb2.StabilityReport(
        requested_mass=mass,
        m_width=m_width(),
        loop=loop(),
        gain_margin_db=20 * math.log10(edge / mass) if mass else math.inf,
        binding="The delay of the loop sets this edge.",
        nearest_admitted_mass=min(max(mass, ADMITTED[0]), ADMITTED[1]),
    )


class FakeServer(
    rendering_pb2_grpc.RenderingServiceServicer,
    stability_pb2_grpc.StabilityServiceServicer,
    telemetry_pb2_grpc.TelemetryServiceServicer,
):
    """Listens on a free port of the loopback inside a with block."""

    def __init__(self):
        self.calls = []
        self.held_by_another = False
        self.renewal_code = None
        self.renewals = 0
        self.end_stream_after = None
        self.last_request = None
        self.stop_reason = None
        self._changed = threading.Condition()
        self._mass = 0.0
        self._state = rendering.STATE_IDLE
        self._server = grpc.server(concurrent.futures.ThreadPoolExecutor(8))
        rendering_pb2_grpc.add_RenderingServiceServicer_to_server(self, self._server)
        stability_pb2_grpc.add_StabilityServiceServicer_to_server(self, self._server)
        telemetry_pb2_grpc.add_TelemetryServiceServicer_to_server(self, self._server)
        self.address = f"127.0.0.1:{self._server.add_insecure_port('127.0.0.1:0')}"

    def __enter__(self):
        self._server.start()
        return self

    def __exit__(self, *_):
        self._server.stop(grace=None).wait()

    def wait_for_renewals(self, count):
        with self._changed:
            return self._changed.wait_for(lambda: self.renewals >= count, timeout=60)

    def _fail(self, context, code, reason, message, report=None):
        status = status_pb2.Status(code=code.value[0], message=message)
        status.details.add().Pack(error_details_pb2.ErrorInfo(domain="mwidth", reason=reason))
        if report is not None:
            status.details.add().Pack(report)
        context.set_trailing_metadata((("grpc-status-details-bin", status.SerializeToString()),))
        context.abort(code, message)

    def _check(self, request, context):
        if request.axis not in ("", "elbow"):
            self._fail(context, grpc.StatusCode.NOT_FOUND, "UNKNOWN_AXIS", "no such axis")
        if getattr(request, "lease_id", "secret") != "secret":
            self._fail(context, grpc.StatusCode.FAILED_PRECONDITION, "NO_LEASE", "acquire control first")
        self.last_request = request

    def GetState(self, request, context):
        self._check(request, context)
        info = rendering.AxisInfo(
            name="elbow", kind=rendering.AXIS_KIND_ROTARY, loop=loop(), mass_min=-10, mass_max=10, simulated=True
        )
        axis = rendering.AxisState(
            info=info, state=self._state, mass=self._mass, target_mass=self._mass, m_width=m_width()
        )
        return rendering.GetStateResponse(axes=[axis], server_version="9.9.9")

    def AcquireControl(self, request, context):
        self._check(request, context)
        if self.held_by_another:
            self._fail(context, grpc.StatusCode.FAILED_PRECONDITION, "CONTROL_HELD", "control is held by somebody")
        self.calls.append("AcquireControl")
        lease = rendering.ControlLease(lease_id="secret", ttl=request.ttl)
        if not request.HasField("ttl"):
            lease.ttl.seconds = 1
        return rendering.AcquireControlResponse(lease=lease)

    def RenewControl(self, request, context):
        with self._changed:
            self.renewals += 1
            self._changed.notify_all()
        if self.renewal_code is not None:
            context.abort(self.renewal_code, "no renewal")
        return rendering.RenewControlResponse()

    def ReleaseControl(self, request, context):
        self._check(request, context)
        self.calls.append("ReleaseControl")
        return rendering.ReleaseControlResponse()

    def StartRendering(self, request, context):
        self._check(request, context)
        self.calls.append("StartRendering")
        self._state = rendering.STATE_RENDERING
        return rendering.StartRenderingResponse(state=self._state)

    def StopRendering(self, request, context):
        self._check(request, context)
        self.calls.append("StopRendering")
        self._state = rendering.STATE_READY
        return rendering.StopRenderingResponse(state=self._state)

    def ClearFault(self, request, context):
        self._check(request, context)
        self._state = rendering.STATE_IDLE
        return rendering.ClearFaultResponse(state=self._state)

    def EmergencyStop(self, request, context):
        self._check(request, context)
        self.stop_reason = request.reason
        self._state = rendering.STATE_FAULT
        return rendering.EmergencyStopResponse(states=[self._state], axes=["elbow"])

    def SetMass(self, request, context):
        self._check(request, context)
        if not math.isfinite(request.mass):
            self._fail(context, grpc.StatusCode.INVALID_ARGUMENT, "INVALID_NUMBER", "mass must be finite")
        report = stability_report(request.mass)
        if not ADMITTED[0] < request.mass < ADMITTED[1]:
            report.admitting_cutoff_hz = 4.5
            self._fail(
                context, grpc.StatusCode.FAILED_PRECONDITION, "UNSTABLE_MASS", "that mass is unstable", report
            )
        if not request.validate_only:
            self._mass = request.mass
            self.calls.append("SetMass")
        return rendering.SetMassResponse(mass=request.mass, stability=report)

    def SetFilter(self, request, context):
        """The mass that is set is stable up to a cut-off of 40 Hz."""
        self._check(request, context)
        report = stability_report(self._mass)
        if request.cutoff_hz > MAX_CUTOFF_HZ:
            self._fail(
                context,
                grpc.StatusCode.FAILED_PRECONDITION,
                "UNSTABLE_MASS",
                "the mass that is set would be unstable",
                report,
            )
        report.loop.cutoff_hz = request.cutoff_hz
        if request.estimator:
            report.loop.estimator = request.estimator
        if not request.validate_only:
            self.calls.append("SetFilter")
        return rendering.SetFilterResponse(loop=report.loop, stability=report)

    def GetMWidth(self, request, context):
        self._check(request, context)
        return stability_pb2.GetMWidthResponse(m_width=m_width(), loop=analysed(request))

    def SweepMWidth(self, request, context):
        """Two rows, the edges x and -x, where y is given; otherwise one."""
        self._check(request, context)
        rows = 2 if request.HasField("y") else 1
        x = np.linspace(request.x.min, request.x.max, request.x.count)
        for row in range(rows):
            yield stability_pb2.SweepMWidthResponse(
                row=row, row_count=rows, y=request.y.min + row, x=x, min=-x, max=[*x[:-1], math.nan]
            )

    def GetFrequencyResponse(self, request, context):
        self._check(request, context)
        return stability_pb2.GetFrequencyResponseResponse(loop=analysed(request), frequency_hz=[1, 2])

    def GetAccuracy(self, request, context):
        self._check(request, context)
        return stability_pb2.GetAccuracyResponse(
            loop=analysed(request), accuracy=stability_pb2.Accuracy(ideal_mass=DEVICE_MASS + request.mass)
        )

    def StreamSamples(self, request, context):
        """Before the third batch, two ticks are missed and three not delivered."""
        self._check(request, context)
        step = max(1, request.decimation)
        size = request.max_batch or 100
        first = 1000
        number = 0
        while context.is_active():
            number += 1
            if number == self.end_stream_after:
                context.abort(grpc.StatusCode.UNAVAILABLE, "the server shuts down")
            gap = number == 3
            first += 5 if gap else 0
            tick = first + step * np.arange(size)
            first += step * size
            position, velocity, acceleration = minimum_jerk(tick * PERIOD_S)
            yield telemetry_pb2.StreamSamplesResponse(
                batch=telemetry_pb2.SampleBatch(
                    axis="elbow",
                    first_tick=int(tick[0]),
                    decimation=step,
                    missed_ticks_before=2 if gap else 0,
                    dropped_ticks_before=3 if gap else 0,
                    monotonic_ns=1_000_000 * tick,
                    position=position,
                    velocity=velocity,
                    acceleration=acceleration,
                    force=self._mass * acceleration,
                    mass=np.full(size, self._mass),
                    state=[self._state] * size,
                    saturated=(tick % 2 == 1).tolist(),
                    position_counts=-tick,
                    force_counts=np.full(size, 12),
                    acceleration_counts=np.full(size, -7),
                )
            )
