"""What happens on an axis, as it happens."""

from mwidth import failure
from mwidth.responses import ResponseStream


class EventStream(ResponseStream):
    """Iterates over mwidth.v1.Event. Made by Client.events. lost counts the events that the server had forgotten before
    they were read.
    """

    def __init__(self, call):
        super().__init__(call)
        self.lost = 0
        # From here on nothing is missed.
        with failure.decoded():
            call.initial_metadata()

    def __next__(self):
        response = self._next_response()
        self.lost += response.lost_before
        return response.event
