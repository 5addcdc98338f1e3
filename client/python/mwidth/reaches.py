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
    """Motion of a SampleBatch without gaps and decimation. Position is as streamed, the derivatives are its own
    (the streamed acceleration lags behind), and the force passes through the same filter as they do."""
    if not np.all(np.diff(batch.tick) == 1):
        raise ValueError("ticks are missing: the derivative would jump")
    return Motion(
        time_s=(batch.tick - batch.tick[0]) * period_s,
        position=batch.position,
        velocity=filtered(batch.position, period_s, 1),
        acceleration=filtered(batch.position, period_s, 2),
        force=filtered(batch.force, period_s),
    )


def find_reaches(moved, before_s, after_s):
    """Reaches in the positive direction, each from before_s before its onset until after_s after it.

    The onset is where the velocity last passes 5 % of the largest velocity on its way up. Reaches that the ends of
    the motion cut off are left out. Time is 0 at the onset.
    """
    fastest = moved.velocity.max()
    starts = np.flatnonzero(np.diff((moved.velocity > 0.5 * fastest).astype(int)) == 1)
    reaches = []
    last_onset_s = -np.inf
    for start in starts:
        slow = np.flatnonzero(moved.velocity[:start] < 0.05 * fastest)
        if len(slow) == 0:
            continue
        onset_s = moved.time_s[slow[-1]]
        # An oscillation after a reach may be fast again; it belongs to that reach.
        if onset_s < last_onset_s + after_s:
            continue
        last_onset_s = onset_s
        if onset_s - before_s >= moved.time_s[0] and onset_s + after_s <= moved.time_s[-1]:
            part = moved[(moved.time_s >= onset_s - before_s) & (moved.time_s <= onset_s + after_s)]
            reaches.append(dataclasses.replace(part, time_s=part.time_s - onset_s))
    return reaches


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


def start_position(reach):
    """Mean position in the first half of the time before the onset: at the onset itself the arm moves already."""
    return reach.position[reach.time_s < 0.5 * reach.time_s[0]].mean()


def overshoot(reaches, amplitude):
    """The farthest position beyond start + amplitude, as a fraction of amplitude; the mean of all reaches."""
    beyond = [reach.position.max() - start_position(reach) - amplitude for reach in reaches]
    return np.mean(beyond) / amplitude
