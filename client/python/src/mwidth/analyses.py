"""What may be asked about a loop, put as the messages of mwidth.v1."""

import dataclasses
from collections.abc import Mapping

import numpy as np

from mwidth.v1 import stability_pb2

_ESTIMATOR = "ESTIMATOR_KIND_"
_PARAMETER = "SWEEP_PARAMETER_"


def to_estimator(estimator):
    """Value of stability_pb2.EstimatorKind of a name such as "kalman", as configurations have it; 0 of None."""
    if estimator is None:
        return stability_pb2.ESTIMATOR_KIND_UNSPECIFIED
    if not isinstance(estimator, str):
        return estimator
    known = {
        name.removeprefix(_ESTIMATOR).lower().replace("_", "-"): value
        for name, value in stability_pb2.EstimatorKind.items()
        if value != stability_pb2.ESTIMATOR_KIND_UNSPECIFIED
    }
    if estimator not in known:
        raise ValueError(f"{estimator!r} is none of the estimators {', '.join(known)}")
    return known[estimator]


def to_loop(overrides):
    """LoopParameters with the given fields; the estimator may be a name."""
    estimator = to_estimator(overrides.get("estimator"))
    return stability_pb2.LoopParameters(**{**overrides, "estimator": estimator})


def to_box(message, box):
    """`box` as a HandEnvelope or DeviceTolerance, `message`: a mapping whose ranges are pairs; None of None."""
    if not isinstance(box, Mapping):
        return box
    fields = {}
    for name, value in box.items():
        if isinstance(value, bool | stability_pb2.ParameterRange):
            fields[name] = value
        else:
            low, high = value
            fields[name] = stability_pb2.ParameterRange(min=low, max=high)
    return message(**fields)


def sweep_range(parameter, first, last, count=21, logarithmic=False):
    """One side of a sweep's grid.

    Args:
        parameter: a field of LoopParameters, such as "cutoff_hz".
        first, last: both included.
        count: number of values, 2 to 10,000.
        logarithmic: equal ratios instead of equal steps; first is then above 0.
    """
    known = [name.removeprefix(_PARAMETER).lower() for name, value in stability_pb2.SweepParameter.items() if value]
    if parameter not in known:
        raise ValueError(f"{parameter!r} is none of the parameters {', '.join(known)}")
    return stability_pb2.SweepRange(
        parameter=_PARAMETER + parameter.upper(), min=first, max=last, count=count, logarithmic=logarithmic
    )


@dataclasses.dataclass(frozen=True)
class Sweep:
    """Nominal edges of the M-width over a grid; NaN where there is none, or where the loop is out of range."""

    x: np.ndarray  # values of the first parameter, shape (n,)
    y: np.ndarray  # values of the second one, shape (rows,); of one row without it, [0]
    min: np.ndarray  # lower edges, shape (rows, n)
    max: np.ndarray  # upper edges, the same


def to_sweep(rows):
    """The Sweep of all SweepMWidthResponses of a call."""
    rows = list(rows)
    return Sweep(
        x=np.array(rows[0].x),
        y=np.array([row.y for row in rows]),
        min=np.array([row.min for row in rows]),
        max=np.array([row.max for row in rows]),
    )
