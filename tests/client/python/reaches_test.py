"""The analysis of reaches, on motions whose answer is known."""

import math
import unittest

import fake_server
import mwidth
import numpy as np
from mwidth import reaches

PERIOD_S = 0.001


def batch(seconds, virtual_mass, position_quantum=0.0):
    """Samples of an ideally rendered mass under the fake server's reaches, with the encoder's quantum."""
    ticks = np.arange(round(seconds / PERIOD_S))
    position, velocity, acceleration = fake_server.minimum_jerk(ticks * PERIOD_S)
    if position_quantum > 0:
        position = position_quantum * np.round(position / position_quantum)
    zero = np.zeros(len(ticks))
    return mwidth.SampleBatch(
        tick=ticks.astype(np.uint64),
        monotonic_ns=1_000_000 * ticks,
        position=position,
        velocity=velocity,
        acceleration=acceleration,
        force=virtual_mass * acceleration,
        mass=zero,
        state=zero,
        saturated=zero,
        position_counts=zero,
        force_counts=zero,
        acceleration_counts=zero,
    )


def find(moved, start=0.0):
    return reaches.find_reaches(moved, start, start + math.radians(30), before_s=0.2, after_s=1.0)


class ReachesTest(unittest.TestCase):
    def test_derivatives_have_no_lag(self):
        time_s = PERIOD_S * np.arange(2000)
        phase = 2 * math.pi * 2 * time_s  # 2 Hz
        inner = slice(50, -50)
        velocity = reaches.filtered(np.sin(phase), PERIOD_S, 1)[inner]
        acceleration = reaches.filtered(np.sin(phase), PERIOD_S, 2)[inner]
        omega = 2 * math.pi * 2
        np.testing.assert_allclose(velocity, omega * np.cos(phase)[inner], atol=1e-4 * omega)
        np.testing.assert_allclose(acceleration, -(omega**2) * np.sin(phase)[inner], atol=1e-3 * omega**2)

    def test_finds_the_outward_reaches_that_are_complete(self):
        moved = reaches.motion(batch(10.1, 0), PERIOD_S)
        found = find(moved)
        # Onsets near 1.2, 5.2 and 9.2 s: the last one is cut off.
        self.assertEqual(len(found), 2)
        for reach in found:
            self.assertLess(abs(reach.time_s[0] + 0.2), 2 * PERIOD_S)
            self.assertLess(abs(reach.time_s[-1] - 1.0), 2 * PERIOD_S)
            self.assertAlmostEqual(reach.position[-1] - reach.position[0], math.radians(30), places=3)

    def test_a_swing_after_a_reach_is_not_a_reach(self):
        moved = reaches.motion(batch(10.1, 0), PERIOD_S)
        swing = np.deg2rad(6) * np.sin(2 * math.pi * 2 * moved.time_s)
        swinging = reaches.Motion(**{**vars(moved), "position": moved.position + swing})
        self.assertEqual(len(find(swinging)), len(find(moved)))

    def test_perceived_mass_of_an_ideal_rendering_is_device_plus_virtual(self):
        for virtual_mass in (0.0, 0.1, -0.03):
            moved = reaches.motion(batch(9, virtual_mass), PERIOD_S)
            found = find(moved)
            perceived = reaches.perceived_mass(found, device_mass=0.05, device_damping=0.1)
            self.assertLess(abs(perceived / (0.05 + virtual_mass) - 1), 0.01)

    def test_the_encoders_quantum_does_not_bias_it(self):
        moved = reaches.motion(batch(9, 0.1, position_quantum=1e-4), PERIOD_S)
        found = find(moved)
        self.assertLess(abs(reaches.perceived_mass(found, 0.05, 0.1) / 0.15 - 1), 0.01)

    def test_a_rendering_of_half_the_mass_is_felt_as_that(self):
        moved = reaches.motion(batch(9, 0.05), PERIOD_S)  # commanded 0.1
        perceived = reaches.perceived_mass(find(moved), 0.05, 0.1)
        self.assertAlmostEqual(reaches.perceived_mass_error(perceived, 0.05, 0.1), -1 / 3, places=2)

    def test_overshoot_is_relative_to_the_way_to_the_target(self):
        samples = batch(9, 0)
        stretched = mwidth.SampleBatch(**{**vars(samples), "position": 1.1 * samples.position + 2})
        found = find(reaches.motion(stretched, PERIOD_S), start=2)
        self.assertAlmostEqual(reaches.overshoot(found, 2, 2 + math.radians(30)), 0.1, places=3)

    def test_short_gaps_are_interpolated(self):
        samples = batch(9, 0.1)
        kept = samples.tick % 1000 > 5  # six ticks missing in each second
        gappy = mwidth.SampleBatch(
            **{name: value[kept] if isinstance(value, np.ndarray) else value for name, value in vars(samples).items()}
        )
        found = find(reaches.motion(gappy, PERIOD_S))
        self.assertEqual(len(found), 2)
        self.assertLess(abs(reaches.perceived_mass(found, 0.05, 0.1) / 0.15 - 1), 0.01)

    def test_long_gaps_are_refused(self):
        samples = batch(1, 0)
        jumped = mwidth.SampleBatch(**{**vars(samples), "tick": samples.tick + 11 * (samples.tick > 500)})
        with self.assertRaisesRegex(ValueError, "too many ticks are missing"):
            reaches.motion(jumped, PERIOD_S)


if __name__ == "__main__":
    unittest.main()
