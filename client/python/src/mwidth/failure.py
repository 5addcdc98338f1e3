"""What the server says when it does not do what was asked."""

import contextlib

import grpc
from google.rpc import error_details_pb2, status_pb2

from mwidth.v1 import stability_pb2


class Error(Exception):
    """A call failed: the server said no, or it could not be reached.

    Attributes:
        code: the grpc.StatusCode.
        reason: the server's constant for it, such as "CONTROL_HELD"; empty where it gave none.
    """

    def __init__(self, message, code, reason=""):
        super().__init__(message)
        self.code = code
        self.reason = reason


class Refused(Error):
    """The server will not render this mass, or not the one that is set with this filter; mass and filter stay.

    Attributes:
        stability: the StabilityReport: m_width.admitted, nearest_admitted_mass, admitting_cutoff_hz, binding, ...
    """

    def __init__(self, message, code, reason, stability):
        super().__init__(message, code, reason)
        self.stability = stability


class LeaseLost(Error):
    """The control lease is gone: another client has it, or no renewal got through in time."""


def _details(call):
    """The messages in the google.rpc.Status that came with a failed call; none where there is no such status."""
    for key, value in call.trailing_metadata() or ():
        if key == "grpc-status-details-bin":
            status = status_pb2.Status()
            # Bytes that do not decode are a proxy's: code and message still hold.
            with contextlib.suppress(Exception):
                status.ParseFromString(value)
            return status.details
    return ()


def decode(call):
    """The Error, or Refused, that a grpc.RpcError stands for."""
    reason = ""
    stability = None
    for detail in _details(call):
        if detail.Is(error_details_pb2.ErrorInfo.DESCRIPTOR):
            info = error_details_pb2.ErrorInfo()
            detail.Unpack(info)
            reason = info.reason
        elif detail.Is(stability_pb2.StabilityReport.DESCRIPTOR):
            stability = stability_pb2.StabilityReport()
            detail.Unpack(stability)
    if stability is not None:
        return Refused(call.details(), call.code(), reason, stability)
    return Error(call.details(), call.code(), reason)


@contextlib.contextmanager
def decoded():
    """Turns a grpc.RpcError inside the with block into an Error."""
    try:
        yield
    except grpc.RpcError as error:
        raise decode(error) from None
