"""Everything that a client may ask of one server."""

import grpc

from mwidth import failure
from mwidth.control import Control, to_duration
from mwidth.samples import SampleStream
from mwidth.v1 import (
    rendering_pb2,
    rendering_pb2_grpc,
    stability_pb2,
    stability_pb2_grpc,
    telemetry_pb2,
    telemetry_pb2_grpc,
)

# A web proxy from the environment must not come between a laboratory's client and its robot.
_OPTIONS = (("grpc.enable_http_proxy", 0),)


class Client:
    """A connection to mwidthd. An empty axis means the only one.

    All methods may be called from any thread, block for one round trip of at most timeout_s, and raise Error.
    The messages that they return are those of mwidth.v1.

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

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """Ends the connection and every stream over it."""
        self._channel.close()

    def _call(self, method, request):
        with failure.decoded():
            return method(request, timeout=self._timeout_s)

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

    def m_width(self, axis="", **overrides):
        """GetMWidthResponse for the axis's loop, with fields of LoopParameters in place of its own.

        client.m_width(cutoff_hz=30, hand_stiffness=0)
        """
        loop = stability_pb2.LoopParameters(**overrides)
        return self._call(self._stability.GetMWidth, stability_pb2.GetMWidthRequest(axis=axis, loop=loop))

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

    def stream(self, axis="", decimation=1, max_batch=0):
        """SampleStream of every decimation-th tick from now on, in batches of at most max_batch (0: the server's)."""
        request = telemetry_pb2.StreamSamplesRequest(axis=axis, decimation=decimation, max_batch=max_batch)
        return SampleStream(self._telemetry.StreamSamples(request))
