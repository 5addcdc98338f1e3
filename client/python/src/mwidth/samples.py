"""The samples of an axis as numpy arrays."""

import dataclasses

import numpy as np

from mwidth.responses import ResponseStream


@dataclasses.dataclass(frozen=True)
class SampleBatch:
    """Columns of equal length n, one entry a sample, in SI units of the axis (m, N, kg or rad, N m, kg m^2).

    missed_ticks_before and dropped_ticks_before count the ticks without a sample since the batch before: never run
    by the loop, or run and not delivered.
    """

    tick: np.ndarray  # uint64
    monotonic_ns: np.ndarray  # int64, the server's clock
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    force: np.ndarray
    mass: np.ndarray
    state: np.ndarray  # int32, values of mwidth.v1.State
    saturated: np.ndarray  # bool
    position_counts: np.ndarray  # int64
    force_counts: np.ndarray  # int32
    acceleration_counts: np.ndarray  # int32, what the accelerometer told; 0 without one
    # Of reduction="min-max": the extremes since the sample before. None otherwise.
    position_min: np.ndarray | None = None
    position_max: np.ndarray | None = None
    velocity_min: np.ndarray | None = None
    velocity_max: np.ndarray | None = None
    acceleration_min: np.ndarray | None = None
    acceleration_max: np.ndarray | None = None
    force_min: np.ndarray | None = None
    force_max: np.ndarray | None = None
    missed_ticks_before: int = 0
    dropped_ticks_before: int = 0

    def __len__(self):
        return len(self.tick)


_DTYPES = {
    "monotonic_ns": np.int64,
    "position": np.float64,
    "velocity": np.float64,
    "acceleration": np.float64,
    "force": np.float64,
    "mass": np.float64,
    "state": np.int32,
    "saturated": np.bool_,
    "position_counts": np.int64,
    "force_counts": np.int32,
    "acceleration_counts": np.int32,
}


_EXTREMES = tuple(f"{of}_{bound}" for of in ("position", "velocity", "acceleration", "force") for bound in ("min", "max"))


class _ReceivedBatch(SampleBatch):
    """A SampleBatch whose columns become arrays when they are first asked for: most readers want few of them, and
    making all takes longer than receiving them.
    """

    def __getattr__(self, name):
        if name == "tick":
            column = self._ticks()
        elif name in _DTYPES:
            # fromiter takes two thirds of the time of array, which looks at every element twice.
            column = np.fromiter(getattr(self._message, name), _DTYPES[name])
            if name == "acceleration_counts" and not len(column):  # a server from before accelerometers
                column = np.zeros(len(self), dtype=np.int32)
        else:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        self.__dict__[name] = column
        return column

    def _ticks(self):
        # A server that left the decimation unset sent every tick.
        step = np.uint64(max(1, self._message.decimation))
        count = len(self._message.position)
        return np.uint64(self._message.first_tick) + np.arange(count, dtype=np.uint64) * step


def from_message(message):
    """SampleBatch of a mwidth.v1.SampleBatch."""
    # Not by __init__, which is that of any SampleBatch, as dataclasses.replace needs it.
    batch = _ReceivedBatch.__new__(_ReceivedBatch)
    batch.__dict__.update(
        {name: np.fromiter(getattr(message, name), np.float64) for name in _EXTREMES if getattr(message, name)},
        _message=message,
        missed_ticks_before=message.missed_ticks_before,
        dropped_ticks_before=message.dropped_ticks_before,
    )
    return batch


def concatenate(batches):
    """One SampleBatch of many, at least one; its gaps are those between them, the first one's own left out."""
    batches = list(batches)
    names = [*_DTYPES, *(name for name in _EXTREMES if getattr(batches[0], name) is not None)]
    return SampleBatch(
        tick=np.concatenate([batch.tick for batch in batches]),
        missed_ticks_before=sum(batch.missed_ticks_before for batch in batches[1:]),
        dropped_ticks_before=sum(batch.dropped_ticks_before for batch in batches[1:]),
        **{name: np.concatenate([getattr(batch, name) for batch in batches]) for name in names},
    )


class SampleStream(ResponseStream):
    """Iterates over SampleBatches. Made by Client.stream.

    missed_ticks and dropped_ticks count those without a sample.
    """

    def __init__(self, call):
        super().__init__(call)
        self.missed_ticks = 0
        self.dropped_ticks = 0

    def __next__(self):
        batch = from_message(self._next_response().batch)
        self.missed_ticks += batch.missed_ticks_before
        self.dropped_ticks += batch.dropped_ticks_before
        return batch
