"""What a stream of samples says about reaching movements: the perceived mass, and how far they overshoot.

Needs scipy, which the rest of the package does not.
"""

import dataclasses

import numpy as np
from scipy.signal import savgol_filter

# Savitzky-Golay: at each sample a polynomial is fitted to the window around it. Symmetric, hence of zero phase: a
# derivative with a lag would mix damping into the mass. A fifth order follows a reach; the window averages the
# encoder's quantum out of the second derivative.
_WINDOW_S = 0.061
_ORDER = 5
# Longest row of ticks without a sample that may be interpolated.
MAX_GAP_S = 0.01


def filtered(x, period_s, derivative=0):
    """x (n samples of period_s), or its first or second derivative, with zero phase."""
    window = 2 * round(_WINDOW_S / period_s / 2) + 1
    if len(x) < window:
        raise ValueError(f"{len(x)} samples are fewer than the filter's window of {window}")
    return savgol_filter(x, window, _ORDER, deriv=derivative, delta=period_s)


@dataclasses.dataclass(frozen=True)
class Motion:
    """Columns of equal length: seconds, rad or m and their derivatives, N m or N."""

    time_s: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    force: np.ndarray

    def __getitem__(self, samples):
        return Motion(*(getattr(self, field.name)[samples] for field in dataclasses.fields(self)))


def motion(batch, period_s):
    """Motion of a SampleBatch without decimation. Position is as streamed, the derivatives are its own (the streamed
    acceleration lags behind), and the force passes through the same filter as they do.

    Ticks without a sample are interpolated, as they are short against the filter's window.

    Raises:
        ValueError: a gap is longer than MAX_GAP_S, or there are fewer samples than the filter's window.
    """
    tick = (batch.tick - batch.tick[0]).astype(np.int64)
    if len(tick) > 1 and (np.diff(tick).max() - 1) * period_s > MAX_GAP_S:
        raise ValueError("too many ticks are missing in a row")
    every_tick = np.arange(tick[-1] + 1)
    position = np.interp(every_tick, tick, batch.position)
    return Motion(
        time_s=every_tick * period_s,
        position=position,
        velocity=filtered(position, period_s, 1),
        acceleration=filtered(position, period_s, 2),
        force=filtered(np.interp(every_tick, tick, batch.force), period_s),
    )


def find_reaches(moved, start, target, before_s, after_s):
    """Reaches from start to target (positions, start < target), each from before_s before its onset until after_s
    after it, time 0 at the onset.

    A reach passes the middle on its way up, having been in the lower quarter before; its onset is where the velocity
    last passes 5 % of the largest one on the way there. Reaches that the ends of the motion cut off are left out.
    """
    way = (moved.position - start) / (target - start)
    threshold = 0.05 * moved.velocity.max()
    reaches = []
    armed = 0  # the first sample not yet searched
    while True:
        below = np.flatnonzero(way[armed:] < 0.25)
        passed = np.flatnonzero(way[armed + below[0] :] > 0.5) if len(below) else below
        if len(passed) == 0:
            return reaches
        middle = armed + below[0] + passed[0]
        armed = middle
        slow = np.flatnonzero(moved.velocity[:middle] < threshold)
        if len(slow) == 0:
            continue
        onset_s = moved.time_s[slow[-1]]
        if onset_s - before_s >= moved.time_s[0] and onset_s + after_s <= moved.time_s[-1]:
            part = moved[(moved.time_s >= onset_s - before_s) & (moved.time_s <= onset_s + after_s)]
            reaches.append(dataclasses.replace(part, time_s=part.time_s - onset_s))


def perceived_mass(reaches, device_mass, device_damping):
    """The mass that moves as the device felt, in the least-squares sense over all reaches.

    m_hat = sum(x'' F_h) / sum(x''^2), with the hand's force F_h = m x'' + b x' + F_a (Colonnese and Okamura,
    RSS 2012, equations 1 and 21 to 23).
    """
    acceleration = np.concatenate([reach.acceleration for reach in reaches])
    velocity = np.concatenate([reach.velocity for reach in reaches])
    force = np.concatenate([reach.force for reach in reaches])
    hand_force = device_mass * acceleration + device_damping * velocity + force
    return acceleration @ hand_force / (acceleration @ acceleration)


def perceived_mass_error(perceived, device_mass, mass):
    """(m_hat - (m + M)) / (m + M), equation 24: negative feels lighter than commanded, positive heavier."""
    return (perceived - (device_mass + mass)) / (device_mass + mass)


def overshoot(reaches, start, target):
    """The farthest position beyond the target, as a fraction of the way from start to target; the mean of all
    reaches. Both are of the task, not of the motion: a heavy arm may still swing when the next reach begins."""
    return np.mean([reach.position.max() - target for reach in reaches]) / (target - start)
