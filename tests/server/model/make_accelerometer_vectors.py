#!/usr/bin/env python3
"""Writes tests/data/accelerometer_vectors.csv: M-widths of random loops with an accelerometer, in 50-digit arithmetic.

    /usr/bin/python3 tests/server/model/make_accelerometer_vectors.py > tests/data/accelerometer_vectors.csv

Needs mpmath (Debian: python3-mpmath); takes some minutes. Shares nothing with the C++ code: device, hand and sensor are one
linear system, discretized by its matrix exponential; a hand that is released has no position in it, and without friction
no velocity either. Crossings of the real axis along the unit circle are bracketed on a grid and refined, and the roots of
the characteristic polynomial must confirm each edge: all inside the circle at several masses up to (1 - 1e-15) of it, one
outside at (1 + 1e-15). With --check FILE it computes every 40th loop anew and compares it with the file.
"""
import random
import sys

from mpmath import expm, matrix, mp, mpf, pi, polyroots

import make_m_width_vectors
from make_m_width_vectors import log_uniform, random_loop, times

SEED = 20090701
HEADER = ("device_mass,device_damping,hand_mass,hand_damping,hand_stiffness,period_s,cutoff_hz,delay_s,"
          "accelerometer_bandwidth_hz,filtered,rise_0,rise_1,rise_2,lower,upper,lower_hz,upper_hz")
COUNTS = {"any": 160, "released": 30, "frictionless": 10, "with_hand_mass": 20, "slow": 20, "heavily_damped": 30,
          "wide_sensor": 20, "slow_sensor": 20}


class Loop(make_m_width_vectors.Loop):
    """Crossings and their confirmation are those of the other script; the open loop is this one's."""

    def __init__(self, mass, damping, hand_mass, hand_damping, stiffness, period, cutoff, delay, bandwidth, filtered):
        self.mu = mpf(mass) + mpf(hand_mass)
        self.beta = mpf(damping) + mpf(hand_damping)
        self.k = mpf(stiffness)
        self.period = mpf(period)
        self.bandwidth = 2 * pi * mpf(bandwidth)
        self.a = mp.exp(-2 * pi * mpf(cutoff) * self.period)
        self.filtered = filtered
        ticks = mpf(delay) / self.period
        self.whole = int(mp.floor(ticks + mpf(10) ** -14))  # what the rounding of 3 * period made is no fraction
        self.fraction = ticks - self.whole if ticks - self.whole > mpf(10) ** -14 else mpf(0)

    def hold(self, duration):
        """State transition and what a unit force during `duration` leaves at its end; the sensor's state is the last."""
        acceleration = {"x": -self.k / self.mu, "v": -self.beta / self.mu, "u": 1 / self.mu}
        states = ["y"] if self.k == 0 and self.beta == 0 else ["v", "y"] if self.k == 0 else ["x", "v", "y"]
        columns = states + ["u"]
        system = matrix(len(columns), len(columns))
        for i, state in enumerate(states):
            for j, column in enumerate(columns):
                if state == "x":
                    system[i, j] = 1 if column == "v" else 0
                elif state == "v":
                    system[i, j] = acceleration.get(column, 0)
                else:
                    system[i, j] = self.bandwidth * (acceleration.get(column, 0) - (1 if column == "y" else 0))
        result = expm(system * duration, method="taylor")
        n = len(states)
        return result[0:n, 0:n], result[0:n, n]

    def prepare(self):
        transition, whole_input = self.hold(self.period)
        _, newest = self.hold((1 - self.fraction) * self.period)
        older = whole_input - newest
        n = self.order = transition.rows
        # Faddeev and LeVerrier: the denominator, and the last row of adj(z - A) by powers of z.
        self.denominator = [mpf(1)]
        adjugate = mp.eye(n)
        numerator = [mpf(0)] * (n + 1)
        for k in range(1, n + 1):
            for i in range(n):
                numerator[k - 1] += adjugate[n - 1, i] * newest[i]
                numerator[k] += adjugate[n - 1, i] * older[i]
            product = transition * adjugate
            coefficient = -sum(product[i, i] for i in range(n)) / k
            self.denominator.append(coefficient)
            adjugate = product + coefficient * mp.eye(n)
        self.numerator = numerator  # over an extra z^(whole + 1)

    def open_loop(self, z):
        low_pass = (1 - self.a) * z / (z - self.a) if self.filtered else 1
        return low_pass * mp.polyval(self.numerator, z) / mp.polyval(self.denominator, z) / z ** (self.whole + 1)

    def roots(self, mass):
        left = times(self.denominator, [mpf(1)] + [mpf(0)] * (self.whole + 1))
        right = [mpf(mass) * x for x in self.numerator]
        if self.filtered:
            left = times(left, [mpf(1), -self.a])
            right = times(right, [1 - self.a, mpf(0)])
        total = list(left)
        for i, x in enumerate(right):
            total[len(total) - len(right) + i] += x
        return polyroots(total, maxsteps=2000, extraprec=400)

    def stable(self, mass):
        return max(map(abs, self.roots(mass))) < 1

    def rise(self):
        """mu times the numerator over w = z - 1, by powers of w, without a released hand's part at z = 1."""
        quotient = [x * self.mu for x in self.numerator]
        if self.fraction == 0:
            quotient = quotient[:-1]  # the power of z that no fraction uses
        for _ in range(3 - self.order):
            quotient = times(quotient, [mpf(1), mpf(-1)])
        powers = []
        while quotient:  # division by z - 1, again and again: the remainders are the powers of w
            shifted, carry = [], mpf(0)
            for x in quotient:
                carry += x
                shifted.append(carry)
            powers.append(shifted.pop())
            quotient = shifted
        assert abs(powers.pop(0)) < mpf(10) ** -40
        return powers + [mpf(0)] * (3 - len(powers))


def random_sensed_loop(rng, kind):
    *loop, _ = random_loop(rng, kind)  # a kind that it does not know is any; its estimator is another one
    period = loop[5]
    bandwidth = log_uniform(rng, 1e-2 / period, 3 / period)
    if kind == "wide_sensor":
        bandwidth = log_uniform(rng, 3 / period, min(1e6, 1e3 / period))
    elif kind == "slow_sensor":
        bandwidth = log_uniform(rng, 1.0, 1e-2 / period) if period < 1e-3 else log_uniform(rng, 0.1, 1.0)
    return (*loop, bandwidth, rng.choice([0, 1]))


def rows():
    rng = random.Random(SEED)
    for kind, count in COUNTS.items():
        for _ in range(count):
            yield random_sensed_loop(rng, kind)


def computed(loop):
    sensed = Loop(*loop)
    try:
        edges = sensed.m_width()
    except AssertionError:
        sys.exit(f"not confirmed: {loop}")
    cells = [repr(float(x)) for x in loop[:-1]] + [str(loop[-1])]
    return ",".join(cells + [mp.nstr(x, 25) for x in sensed.rise()] + [mp.nstr(x, 25) for x in edges])


def main():
    if len(sys.argv) == 3 and sys.argv[1] == "--check":
        with open(sys.argv[2], encoding="ascii") as file:
            lines = file.read().splitlines()[1:]
        for i, loop in enumerate(rows()):
            if i % 40 == 0 and computed(loop) != lines[i]:
                sys.exit(f"row {i} differs")
        return
    print(HEADER)
    for i, loop in enumerate(rows()):
        print(computed(loop), flush=True)
        if i % 50 == 49:
            print(i + 1, file=sys.stderr)


if __name__ == "__main__":
    main()
