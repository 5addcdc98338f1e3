"""The right to command an axis, held for as long as a with block runs."""

import contextlib
import threading
import time

import grpc
from google.protobuf import duration_pb2

from mwidth import analyses, failure
from mwidth.v1 import rendering_pb2

# A renewal that failed this way may succeed when tried again.
_MAY_RETRY = (grpc.StatusCode.UNAVAILABLE, grpc.StatusCode.DEADLINE_EXCEEDED)


def to_duration(seconds):
    """google.protobuf.Duration of so many seconds; None of None."""
    if seconds is None:
        return None
    duration = duration_pb2.Duration()
    duration.FromNanoseconds(round(1e9 * seconds))
    return duration


class Control:
    """The control lease of an axis, made by Client.control.

    A thread renews it at a third of its time to live; leaving the with block releases it, and the server then ramps
    the mass to zero. When this process dies or hangs, the renewals stop and the server does the same.

    All methods may be called from any thread, block for one round trip, and raise Error.
    """

    def __init__(self, stub, axis, lease, timeout_s):
        self._stub = stub
        self._lease = {"axis": axis, "lease_id": lease.lease_id}
        self._ttl_s = lease.ttl.ToNanoseconds() * 1e-9
        self._timeout_s = timeout_s
        self._loss = None
        self._ended = threading.Event()
        self._renewal = threading.Thread(target=self._renew_until_ended, daemon=True, name="mwidth-renewal")
        self._renewal.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.release()

    def release(self):
        """Stops renewing and gives the lease back. Raises nothing: unreleased, the lease expires by itself."""
        if self._ended.is_set():
            return
        self._ended.set()
        self._renewal.join()
        if self._loss is None:
            with contextlib.suppress(grpc.RpcError):
                self._stub.ReleaseControl(rendering_pb2.ReleaseControlRequest(**self._lease), timeout=1)

    @property
    def loss(self):
        """Why the lease is gone, a LeaseLost; None while it is held."""
        return self._loss

    def start_rendering(self):
        """Enables the drive and renders from here on."""
        return self._call(self._stub.StartRendering, rendering_pb2.StartRenderingRequest(**self._lease))

    def stop_rendering(self):
        """Ramps the mass to zero and returns when the force is zero."""
        return self._call(self._stub.StopRendering, rendering_pb2.StopRenderingRequest(**self._lease))

    def set_mass(self, mass, ramp_s=None, validate_only=False):
        """Asks for a virtual mass (kg or kg m^2; negative feels lighter).

        Args:
            ramp_s: time of the ramp to it, 0 to 10 s; None: the server's own.
            validate_only: answer as if, change nothing.

        Returns:
            SetMassResponse with the margins; the loop has taken the mass up, at the start of its ramp.

        Raises:
            Refused: the mass is not admitted; the rendered mass stays.
        """
        request = rendering_pb2.SetMassRequest(
            mass=mass, ramp=to_duration(ramp_s), validate_only=validate_only, **self._lease
        )
        return self._call(self._stub.SetMass, request)

    def set_filter(self, cutoff_hz, estimator=None, validate_only=False):
        """Asks for another filter of the acceleration. The mass that is set stays; while it is rendered the loop takes
        it to zero, changes, and takes it back.

        Args:
            cutoff_hz: above 0, at most half the sample rate.
            estimator: a name such as "kalman", or a value of EstimatorKind; None: the running one. Those that read
                an accelerometer are granted where the drive has one.
            validate_only: answer as if, change nothing.

        Returns:
            SetFilterResponse with the loop, which runs the filter now, and the margins of the mass.

        Raises:
            Refused: the mass that is set is not admitted with this filter; both stay.
        """
        request = rendering_pb2.SetFilterRequest(
            cutoff_hz=cutoff_hz,
            estimator=analyses.to_estimator(estimator),
            validate_only=validate_only,
            **self._lease,
        )
        return self._call(self._stub.SetFilter, request)

    def clear_fault(self):
        """From FAULT to IDLE, once its cause is gone."""
        return self._call(self._stub.ClearFault, rendering_pb2.ClearFaultRequest(**self._lease))

    def _call(self, method, request):
        if self._loss is not None:
            raise self._loss
        with failure.decoded():
            return method(request, timeout=self._timeout_s)

    def _renew_until_ended(self):
        request = rendering_pb2.RenewControlRequest(**self._lease)
        valid_until = time.monotonic() + self._ttl_s
        # A third of the time to live leaves room for one slow renewal and a second try before the lease expires.
        pause_s = self._ttl_s / 3
        while not self._ended.wait(pause_s):
            sent = time.monotonic()
            try:
                self._stub.RenewControl(request, timeout=self._ttl_s / 6)
                # Counted from before the request left: the server counts from later, never from earlier.
                valid_until = sent + self._ttl_s
                pause_s = self._ttl_s / 3
            except grpc.RpcError as error:
                if error.code() in _MAY_RETRY and time.monotonic() < valid_until:
                    pause_s = self._ttl_s / 12
                    continue
                answer = failure.decode(error)
                self._loss = failure.LeaseLost(str(answer), answer.code, answer.reason)
                return
