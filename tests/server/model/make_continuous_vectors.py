#!/usr/bin/env python3
"""Writes tests/data/continuous_vectors.csv: edges of the continuous model for random loops, in 50-digit arithmetic.

    /usr/bin/python3 tests/server/model/make_continuous_vectors.py > tests/data/continuous_vectors.csv
    /usr/bin/python3 tests/server/model/make_continuous_vectors.py --check tests/data/continuous_vectors.csv

With --check it makes the first loops anew and fails where the file says anything else.
Needs mpmath (Debian: python3-mpmath); takes some minutes. Shares nothing with the C++ code, which follows the phase
from crossing to crossing: here the zeros of Im L(jw) are bracketed on a fine grid of frequencies and refined. Then the
argument principle must confirm each edge: all roots of 1 + L on the left at 99.9 % of it and at smaller masses, some on
the right at 100.1 %. A loop that fails this stops the script: no vector is written unconfirmed.
"""
import random
import sys
from itertools import islice

from mpmath import arg, exp, mp, mpc, mpf, pi, sqrt

mp.dps = 50
SEED = 20120710
LOOPS = 120
CHECKED = 4
FIELDS = "device_mass,device_damping,hand_mass,hand_damping,hand_stiffness,period_s,cutoff_hz,delay_s"


def log_uniform(rng, low, high):
    return low * (high / low) ** rng.random()


def random_loop(rng, number):
    """In the order of FIELDS, as doubles."""
    period = log_uniform(rng, 1e-5, 1e-2)
    damping, hand_damping = log_uniform(rng, 1e-4, 1e1), log_uniform(rng, 1e-2, 3e2)
    stiffness = log_uniform(rng, 1.0, 3e4)
    if number % 5 == 3:
        stiffness, hand_damping = 0.0, rng.choice([0.0, hand_damping])
    hand_mass = log_uniform(rng, 1e-3, 1.0) if number % 4 == 1 else 0.0
    delay = rng.choice([0.0, period, 3 * period * rng.random()])
    mass, cutoff = log_uniform(rng, 1e-3, 1e2), log_uniform(rng, 0.3, 0.48 / period)
    return mass, damping, hand_mass, hand_damping, stiffness, period, cutoff, delay


def bisect(function, low, at_low, high):
    for _ in range(130):
        middle = (low + high) / 2
        at_middle = function(middle)
        if at_low * at_middle > 0:
            low, at_low = middle, at_middle
        else:
            high = middle
    return (low + high) / 2


class Loop:
    def __init__(self, mass, damping, hand_mass, hand_damping, stiffness, period, cutoff, delay):
        self.mu, self.beta, self.k = mpf(mass) + mpf(hand_mass), mpf(damping) + mpf(hand_damping), mpf(stiffness)
        self.period, self.cutoff, self.delay = mpf(period), 2 * pi * mpf(cutoff), mpf(delay)
        # A released hand leaves a factor s in plant and estimator: divided out.
        self.free = 1 if self.k == 0 else 0

    def plant(self, s):
        """Denominator of L, all but the estimator's zeros."""
        second_order = self.mu * s + self.beta if self.free else self.mu * s**2 + self.beta * s + self.k
        return second_order * (s * self.period + 2) ** 2 * (s + self.cutoff)

    def feedback(self, s):
        """Numerator of L at M = 1."""
        return 4 * s ** (2 - self.free) * self.cutoff * exp(-s * (self.period / 2 + self.delay))

    def grid(self):
        resonance = sqrt(self.k / self.mu)
        width = self.beta / self.mu / 40
        low = min(self.cutoff, 1 / self.period, resonance or self.beta / self.mu, (self.k / self.beta) or 1) / 1000
        high = 40 * max(1 / self.period, resonance)
        points = [low * (high / low) ** (mpf(i) / 1200) for i in range(1201)]
        points += [resonance + width * i for i in range(-80, 80) if resonance + width * i > low]
        # Dead time turns at a constant rate.
        points += [high * i / 400 for i in range(1, 401)]
        # From there on nothing turns any more.
        points.append(100 * (high + self.beta / self.mu))
        return sorted(set(points))

    def edges(self, points):
        def sine(w):
            return (self.feedback(mpc(0, w)) * self.plant(mpc(0, w)).conjugate()).imag

        nearest = {}
        before = sine(points[0])
        for low, high in zip(points, points[1:]):
            value = sine(high)
            if before * value <= 0:
                w = bisect(sine, low, before, high)
                mass = (-self.plant(mpc(0, w)) / self.feedback(mpc(0, w))).real
                side = mass > 0
                if side not in nearest or abs(mass) < abs(nearest[side][0]):
                    nearest[side] = mass, w / (2 * pi)
            before = value
        return nearest[False], nearest[True]

    def stable(self, mass, points):
        """The phase of the characteristic function must grow by a quarter turn for each of its roots."""

        def value(w):
            return self.plant(mpc(0, w)) + mass * self.feedback(mpc(0, w))

        def turn(low, at_low, high, at_high, depth=60):
            step = arg(at_high / at_low)
            if abs(step) < 0.5:
                return step
            assert depth > 0, "the phase jumps: a root on the axis"
            middle = (low + high) / 2
            at_middle = value(middle)
            return turn(low, at_low, middle, at_middle, depth - 1) + turn(middle, at_middle, high, at_high, depth - 1)

        turned, low, at_low = mpf(0), mpf(0), value(mpf(0))
        for high in points:
            at_high = value(high)
            turned += turn(low, at_low, high, at_high)
            low, at_low = high, at_high
        quarter_turns = turned / (pi / 2)
        assert abs(quarter_turns - round(quarter_turns)) < 0.2
        return round(quarter_turns) == 5 - self.free


def vectors():
    rng = random.Random(SEED)
    yield FIELDS + ",lower_mass,lower_critical_hz,upper_mass,upper_critical_hz"
    for number in range(LOOPS):
        parameters = random_loop(rng, number)
        loop = Loop(*parameters)
        points = loop.grid()
        lower, upper = loop.edges(points)
        for edge in (lower[0], upper[0]):
            for share in (0.3, 0.999):
                assert loop.stable(edge * share, points), (number, share)
            assert not loop.stable(edge * 1.001, points), number
        yield ",".join([repr(p) for p in parameters] + [mp.nstr(v, 20) for v in (*lower, *upper)])


def main():
    if sys.argv[1:2] == ["--check"]:
        with open(sys.argv[2], encoding="ascii") as file:
            for line, vector in zip(islice(file, CHECKED + 1), vectors()):
                assert line.strip() == vector, f"stored: {line}made: {vector}"
        return
    for vector in vectors():
        print(vector)


if __name__ == "__main__":
    main()
