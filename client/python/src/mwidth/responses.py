"""What the streaming calls have in common."""

import grpc

from mwidth import failure


class ResponseStream:
    """Responses of one call until cancel() or the end of a with block.

    Iterate from one thread; cancel may come from any other. Raises Error when the server ends the stream with one.
    """

    # Whether it has an end of its own.
    _ends = False

    def __init__(self, call):
        self._call = call
        self._cancelled = False

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.cancel()

    def cancel(self):
        """Ends the iteration, a waiting one too."""
        self._cancelled = True
        self._call.cancel()

    def __iter__(self):
        return self

    def _next_response(self):
        try:
            return next(self._call)
        except StopIteration:
            if self._cancelled or self._ends:
                raise
            raise failure.Error("the server ended the stream", grpc.StatusCode.UNAVAILABLE) from None
        except grpc.RpcError as error:
            if self._cancelled:
                raise StopIteration from None
            raise failure.decode(error) from None
