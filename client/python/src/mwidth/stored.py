"""A session as it was recorded."""

from mwidth import samples
from mwidth.responses import ResponseStream


class StoredSession(ResponseStream):
    """Iterates over a session in the order of time: SampleBatch for samples, mwidth.v1.Event, mwidth.v1.Marker. Made by
    Client.read_session.
    """

    _ends = True

    def __next__(self):
        response = self._next_response()
        if response.HasField("batch"):
            return samples.from_message(response.batch)
        return getattr(response, response.WhichOneof("record"))

    def samples(self):
        """SampleBatch of all that is left, the rest passed over; at least one sample."""
        return samples.concatenate(each for each in self if isinstance(each, samples.SampleBatch))
