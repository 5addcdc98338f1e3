"""Everything that a client may ask of one server."""

import grpc
from grpc import experimental

from mwidth import analyses, clock, failure
from mwidth.control import Control, to_duration
from mwidth.events import EventStream
from mwidth.samples import SampleStream
from mwidth.session import Session
from mwidth.stored import StoredSession
from mwidth.v1 import (
    rendering_pb2,
    rendering_pb2_grpc,
    session_pb2,
    session_pb2_grpc,
    stability_pb2,
    stability_pb2_grpc,
    telemetry_pb2,
    telemetry_pb2_grpc,
)

_OPTIONS = (
    # A web proxy from the environment must not come between a laboratory's client and its robot.
    ("grpc.enable_http_proxy", 0),
    # Not to measure the connection's bandwidth by pings, of which each wakes client and server: samples come at a steady
    # rate. A window of a fixed size lets a stored session through at 256 KiB a round trip.
    ("grpc.http2.bdp_probe", 0),
    ("grpc.http2.lookahead_bytes", 256 * 1024),
    # Whoever iterates over a stream also reads it: a thread between them would have to be woken for each message.
    (experimental.ChannelOptions.SingleThreadedUnaryStream, 1),
)

# Bound on what the server computes for longer: sweeps, simulations, and proofs over an envelope.
_ANALYSIS_TIMEOUT_S = 300


class Client:
    """A connection to mwidthd. An empty axis means the only one.

    All methods may be called from any thread, block for one round trip of at most timeout_s (300 s where the server
    computes for longer: sweeps, simulations, envelopes), and raise Error. The messages that they return are those of
    mwidth.v1.

    The analyses take fields of LoopParameters in place of the axis's own: device_mass, device_damping, hand_mass,
    hand_damping, hand_stiffness, period_s, cutoff_hz, delay_s, accelerometer_bandwidth_hz, and estimator by its name
    ("kalman", say; "accelerometer" and "filtered-accelerometer" need a bandwidth where the axis has no accelerometer).

    Args:
        address: "HOST:PORT".
        timeout_s: bound on the connection attempt and on every call.
    """

    def __init__(self, address="127.0.0.1:50051", timeout_s=5.0):
        self._timeout_s = timeout_s
        self._channel = grpc.insecure_channel(address, options=_OPTIONS)
        self._rendering = rendering_pb2_grpc.RenderingServiceStub(self._channel)
        self._stability = stability_pb2_grpc.StabilityServiceStub(self._channel)
        self._telemetry = telemetry_pb2_grpc.TelemetryServiceStub(self._channel)
        self._sessions = session_pb2_grpc.SessionServiceStub(self._channel)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """Ends the connection and every stream over it."""
        self._channel.close()

    def _call(self, method, request, long=False):
        with failure.decoded():
            return method(request, timeout=_ANALYSIS_TIMEOUT_S if long else self._timeout_s)

    def state(self, axis=""):
        """GetStateResponse: what the axes are and what they are doing; an empty axis means all."""
        return self._call(self._rendering.GetState, rendering_pb2.GetStateRequest(axis=axis))

    def axis(self, axis=""):
        """AxisState of one axis."""
        axes = self.state(axis).axes
        if len(axes) != 1:
            names = ", ".join(each.info.name for each in axes)
            raise failure.Error(f"name one of the server's axes: {names}", grpc.StatusCode.NOT_FOUND)
        return axes[0]

    def m_width(self, axis="", envelope=None, tolerance=None, **overrides):
        """GetMWidthResponse: which masses are stable.

            client.m_width(cutoff_hz=30, hand_stiffness=0)
            client.m_width(envelope={"stiffness": (100, 2000), "include_released_hand": True})

        Args:
            envelope: hands that every robust mass is stable with, a HandEnvelope or its fields: pairs of least and
                greatest stiffness, damping and mass, the loop's own where left out, and include_released_hand.
            tolerance: the same of the device: a DeviceTolerance, or pairs of mass and damping. Without either the
                axis's own hold; an override of the loop leaves exactly that loop.
        """
        request = stability_pb2.GetMWidthRequest(
            axis=axis,
            loop=analyses.to_loop(overrides),
            envelope=analyses.to_box(stability_pb2.HandEnvelope, envelope),
            tolerance=analyses.to_box(stability_pb2.DeviceTolerance, tolerance),
        )
        return self._call(
            self._stability.GetMWidth, request, long=envelope is not None or tolerance is not None
        )

    def sweep(self, x, y=None, axis="", **overrides):
        """Sweep: nominal edges over a grid of one or two parameters, of at most 1,000,000 points.

            client.sweep(mwidth.sweep_range("cutoff_hz", 1, 100, count=50, logarithmic=True))

        Args:
            x, y: SweepRanges, made by sweep_range; y may be left out.
        """
        request = stability_pb2.SweepMWidthRequest(axis=axis, loop=analyses.to_loop(overrides), x=x, y=y)
        with failure.decoded():
            return analyses.to_sweep(self._stability.SweepMWidth(request, timeout=_ANALYSIS_TIMEOUT_S))

    def frequency_response(self, mass, axis="", min_hz=0.0, max_hz=0.0, count=0, continuous=False, **overrides):
        """GetFrequencyResponseResponse: Bode data of the loop with a virtual mass, its margins, and how heavy and how
        damped the device feels.

        Args:
            min_hz, max_hz: frequencies at equal ratios; 0: from 0.1 Hz, to half the sample rate.
            count: number of frequencies, 2 to 10,000; 0: 200.
            continuous: the paper's continuous approximation instead of the sampled loop.
        """
        model = stability_pb2.RESPONSE_MODEL_CONTINUOUS if continuous else stability_pb2.RESPONSE_MODEL_DISCRETE
        request = stability_pb2.GetFrequencyResponseRequest(
            axis=axis,
            loop=analyses.to_loop(overrides),
            mass=mass,
            min_hz=min_hz,
            max_hz=max_hz,
            count=count,
            model=model,
        )
        return self._call(self._stability.GetFrequencyResponse, request)

    def accuracy(self, mass, axis="", min_hz=0.0, max_hz=0.0, duration_s=0.0, simulate=False, **overrides):
        """GetAccuracyResponse: how truly and how quietly a mass is rendered. An unstable mass is no error: its answer
        has accuracy.unavailable_reason in place of figures.

        Args:
            min_hz, max_hz, duration_s: the motion, a linear chirp; 0: that of the paper's Figure 9, 0.1 to 5 Hz in
                60 s.
            simulate: simulate as well as predict.
        """
        request = stability_pb2.GetAccuracyRequest(
            axis=axis,
            loop=analyses.to_loop(overrides),
            mass=mass,
            band=stability_pb2.MotionBand(min_hz=min_hz, max_hz=max_hz, duration_s=duration_s),
            simulate=simulate,
        )
        return self._call(self._stability.GetAccuracy, request, long=simulate)

    def emergency_stop(self, reason, axis=""):
        """Zero force on the next tick, fault latched. For anyone, without a lease.

        On every axis of the server; `axis` is only for the record. Returns the axes with their states after the stop.
        """
        request = rendering_pb2.EmergencyStopRequest(axis=axis, reason=reason)
        return self._call(self._rendering.EmergencyStop, request)

    def control(self, client_name, axis="", ttl_s=None):
        """Takes the control lease and returns the Control that renews it; use it in a with statement.

        Args:
            client_name: shown to people who look at the state.
            ttl_s: time to live of the lease, 0.1 to 60 s; None: the server's own (1 s).

        Raises:
            Error: with reason CONTROL_HELD where another client has control.
        """
        request = rendering_pb2.AcquireControlRequest(axis=axis, client_name=client_name, ttl=to_duration(ttl_s))
        lease = self._call(self._rendering.AcquireControl, request).lease
        return Control(self._rendering, axis, lease, self._timeout_s)

    def stream(self, axis="", decimation=1, max_batch=0, min_batch=0, reduction="pick"):
        """SampleStream of every decimation-th tick from now on.

            for batch in client.stream(min_batch=100):  # a tenth of a second at 1 kHz, for a fraction of the work

        Args:
            max_batch: most samples in a batch; 0: the server's choice.
            min_batch: fewest samples in a batch, held back until they are there; 0: what is there.
            reduction: how many ticks become one sample: "pick" takes one as it is, "low-pass" filters before (flat to
                0.8 of half the new rate), "min-max" adds the extremes since the sample before.
        """
        name = "REDUCTION_" + reduction.upper().replace("-", "_")
        request = telemetry_pb2.StreamSamplesRequest(
            axis=axis,
            decimation=decimation,
            max_batch=max_batch,
            min_batch=min_batch,
            reduction=telemetry_pb2.Reduction.Value(name),
        )
        return SampleStream(self._telemetry.StreamSamples(request))

    def events(self, axis="", after_number=None):
        """EventStream of what happens on an axis from now on, or behind an event of that number (0: from the first one
        that the server remembers).
        """
        request = telemetry_pb2.StreamEventsRequest(axis=axis, after_number=after_number)
        return EventStream(self._telemetry.StreamEvents(request))

    def sync_clock(self, axis="", count=16):
        """ClockOffset from this process's time.monotonic_ns() to the axis's clock, the best of `count` exchanges."""

        def ask(client_ns):
            request = telemetry_pb2.SyncClockRequest(axis=axis, client_send_ns=client_ns)
            return self._call(self._telemetry.SyncClock, request)

        return clock.measure(ask, count)

    def session(self, subject, task, run=0, visit="", operator="", metadata=None, axis=""):
        """Begins to record an axis and returns the Session; use it in a with statement.

        Args:
            subject, task, visit: letters and digits, such as "sub-01", "reach", "ses-1".
            run: 1 to 9999; 0: the next one of this subject, visit and task.
            operator: who runs the session, if it is to be told.
            metadata: free, kept as text.
        """
        labels = session_pb2.SessionLabels(
            subject=subject,
            visit=visit,
            task=task,
            run=run,
            operator=operator,
            metadata={key: str(value) for key, value in (metadata or {}).items()},
        )
        request = session_pb2.StartSessionRequest(axis=axis, labels=labels)
        return Session(self, axis, lambda: self._call(self._sessions.StartSession, request).session)

    def sessions(self, subject="", visit="", task=""):
        """List of mwidth.v1.Session in the server's folder, the newest first; only those of a subject, visit or task."""
        request = session_pb2.ListSessionsRequest(subject=subject, visit=visit, task=task)
        return list(self._call(self._sessions.ListSessions, request).sessions)

    def stored_session(self, session_id):
        """GetSessionResponse: what a session says of itself, its events, markers and configuration."""
        request = session_pb2.GetSessionRequest(session_id=session_id)
        return self._call(self._sessions.GetSession, request)

    def read_session(self, session_id, first_tick=0, last_tick=0, speed=0.0, max_batch=1000):
        """StoredSession: iterates over the samples, events and markers of a session, in the order of time.

        Args:
            first_tick, last_tick: a part of it; 0: from its first, to its last.
            speed: how many times as fast as it was; 0: as fast as it is read.
        """
        request = session_pb2.ReadSessionRequest(
            session_id=session_id, first_tick=first_tick, last_tick=last_tick, speed=speed, max_batch=max_batch
        )
        return StoredSession(self._sessions.ReadSession(request))
