#!/usr/bin/env python3
"""Writes tests/data/m_width_vectors.csv: M-widths of random loops, in 50-digit arithmetic.

    /usr/bin/python3 tests/server/model/make_m_width_vectors.py > tests/data/m_width_vectors.csv

Needs mpmath (Debian: python3-mpmath); takes some minutes. Shares nothing with the C++ code: the plant is discretized by
the matrix exponential, the open loop is evaluated as printed (eqs. 3 to 5), the zeros of its imaginary part along the
unit circle are bracketed on a grid and refined. Then the roots of the characteristic polynomial must confirm each edge:
all inside the circle at several masses up to (1 - 1e-15) of it, one outside at (1 + 1e-15). A loop that fails this stops
the script: no vector is written unconfirmed.
"""
import random
import sys

from mpmath import expm, findroot, log, matrix, mp, mpc, mpf, pi, polyroots

mp.dps = 50
SEED = 20120709
NEAR = mpf(10) ** -15


def log_uniform(rng, low, high):
    return low * (high / low) ** rng.random()


def random_loop(rng, kind):
    """(m, b, m_h, b_h, k_h, T, f0, delay) as doubles."""
    period = log_uniform(rng, 1e-5, 1e-2)
    mass, hand_mass = log_uniform(rng, 1e-3, 1e2), 0.0
    damping, hand_damping = log_uniform(rng, 1e-4, 1e1), log_uniform(rng, 1e-2, 3e2)
    stiffness = log_uniform(rng, 1.0, 3e4)
    cutoff = log_uniform(rng, 0.3, 0.48 / period)
    delay = rng.choice([0.0, 0.0, period, 2 * period, 3 * period] + 4 * [3 * period * rng.random()])
    if kind == "released":
        stiffness, hand_damping = 0.0, rng.choice([0.0, hand_damping])
    elif kind == "frictionless":
        stiffness, hand_damping, damping = 0.0, 0.0, 0.0
    elif kind == "with_hand_mass":
        hand_mass = log_uniform(rng, 1e-3, 1e1)
    elif kind == "slow":  # natural frequency times period down to 1e-5
        period, mass, stiffness = log_uniform(rng, 1e-5, 1e-4), log_uniform(rng, 1, 1e2), log_uniform(rng, 1, 1e2)
        cutoff, delay = log_uniform(rng, 0.3, 0.48 / period), rng.choice([0, 1, 2.5]) * period
    elif kind == "heavily_damped":  # damping per tick up to 3000
        period, mass, hand_damping = 1e-2, log_uniform(rng, 1e-3, 1e-2), log_uniform(rng, 30, 300)
        cutoff, delay = log_uniform(rng, 0.3, 48), rng.choice([0, 1, 0.3, 2.5]) * period
    return mass, damping, hand_mass, hand_damping, stiffness, period, cutoff, delay


class Loop:
    def __init__(self, mass, damping, hand_mass, hand_damping, stiffness, period, cutoff, delay):
        self.mu = mpf(mass) + mpf(hand_mass)
        self.beta = mpf(damping) + mpf(hand_damping)
        self.k = mpf(stiffness)
        self.period = mpf(period)
        self.a = mp.exp(-2 * pi * mpf(cutoff) * self.period)
        ticks = mpf(delay) / self.period
        self.whole = int(mp.floor(ticks))
        fraction = ticks - self.whole
        self.transition, whole_input = self.hold(self.period)
        _, self.newest = self.hold((1 - fraction) * self.period)
        self.older = whole_input - self.newest

    def hold(self, duration):
        """State transition and the effect of a unit force during `duration`, both at its end."""
        system = matrix(3, 3)
        system[0, 1] = 1
        system[1, 0], system[1, 1], system[1, 2] = -self.k / self.mu, -self.beta / self.mu, 1 / self.mu
        result = expm(system * duration, method="taylor")
        return result[0:2, 0:2], result[0:2, 2]

    def plant_polynomials(self):
        """Numerator (over an extra z^(whole + 1)) and denominator of G, highest power first."""
        t, n, o = self.transition, self.newest, self.older
        first_row = [(n[0], -t[1, 1] * n[0] + t[0, 1] * n[1]), (o[0], -t[1, 1] * o[0] + t[0, 1] * o[1])]
        numerator = [first_row[0][0], first_row[0][1] + first_row[1][0], first_row[1][1]]
        trace = t[0, 0] + t[1, 1]
        return numerator, [mpf(1), -trace, t[0, 0] * t[1, 1] - t[0, 1] * t[1, 0]]

    def prepare(self):
        self.numerator, self.denominator = self.plant_polynomials()

    def open_loop(self, z):
        """H D G z^-delay for a unit mass."""
        double_difference = (z - 1) ** 2 / (self.period * z) ** 2
        low_pass = (1 - self.a) * z / (z - self.a)
        plant = mp.polyval(self.numerator, z) / mp.polyval(self.denominator, z) / z ** (self.whole + 1)
        return double_difference * low_pass * plant

    def roots(self, mass):
        """Closed-loop poles; poles at z = 1 of a released hand, which the double difference hides, left out."""
        def times(p, q):
            product = [mpf(0)] * (len(p) + len(q) - 1)
            for i, x in enumerate(p):
                for j, y in enumerate(q):
                    product[i + j] += x * y
            return product

        plant, square = self.denominator, [mpf(1), mpf(-2), mpf(1)]
        if self.k == 0:
            plant, square = [mpf(1), -mp.exp(-self.beta * self.period / self.mu)], [mpf(1), mpf(-1)]
            if self.beta == 0:
                plant, square = [mpf(1)], [mpf(1)]
        left = times(times(plant, [mpf(1), -self.a]), [mpf(1)] + [mpf(0)] * (self.whole + 2))
        right = times(square, self.numerator)
        gain = mpf(mass) * (1 - self.a) / self.period**2
        total = list(left)
        for i, x in enumerate(right):
            total[len(total) - len(right) + i] += gain * x
        return polyroots(total, maxsteps=2000, extraprec=400)

    def crossings(self):
        """(mass, angle) wherever the open loop is real on the circle."""
        def imaginary(angle):
            return self.open_loop(mp.expj(angle)).imag

        grid = [mp.exp(log(mpf(10) ** -8) + i * (log(pi) - log(mpf(10) ** -8)) / 500) for i in range(500)]
        grid += [pi * i / 200 for i in range(1, 200)]
        for pole in polyroots(self.denominator, maxsteps=500, extraprec=400):
            angle, width = abs(mp.arg(pole)), abs(log(abs(pole)))
            grid += [angle + sign * width * mpf(2) ** i for sign in (-1, 1) for i in range(-40, 8)]
        grid = sorted(t for t in grid if 0 < t < pi)
        values = [imaginary(t) for t in grid]
        found = []
        for low, high, at_low, at_high in zip(grid, grid[1:], values, values[1:]):
            if at_low * at_high < 0:
                angle = findroot(imaginary, (low, high), solver="illinois", tol=mpf(10) ** -80, maxsteps=400,
                                 verify=False)
                found.append((-1 / self.open_loop(mp.expj(angle)).real, angle))
        at_minus_one = self.open_loop(mpc(-1)).real
        if at_minus_one != 0:  # as it is for a free mass without friction
            found.append((-1 / at_minus_one, +pi))
        if self.beta == 0 and self.k == 0:
            found.append((-self.mu, mpf(0)))
        return found

    def confirm(self, edge):
        for share in ("0.01", "0.1", "0.5", "0.9"):
            assert max(map(abs, self.roots(edge * mpf(share)))) < 1
        assert max(map(abs, self.roots(edge * (1 - NEAR)))) < 1
        assert max(map(abs, self.roots(edge * (1 + NEAR)))) > 1

    def m_width(self):
        self.prepare()
        crossings = self.crossings()
        lower = max(c for c in crossings if c[0] < 0)
        upper = min(c for c in crossings if c[0] > 0)
        self.confirm(lower[0])
        self.confirm(upper[0])
        hz = [c[1] / (2 * pi * self.period) for c in (lower, upper)]
        return lower[0], upper[0], hz[0], hz[1]


def main():
    rng = random.Random(SEED)
    print("device_mass,device_damping,hand_mass,hand_damping,hand_stiffness,period_s,cutoff_hz,delay_s,"
          "lower,upper,lower_hz,upper_hz")
    counts = {"any": 400, "released": 50, "frictionless": 20, "with_hand_mass": 30, "slow": 50, "heavily_damped": 50}
    for kind, count in counts.items():
        for i in range(count):
            loop = random_loop(rng, kind)
            try:
                edges = Loop(*loop).m_width()
            except AssertionError:
                sys.exit(f"not confirmed: {kind} {loop}")
            print(",".join([repr(float(x)) for x in loop] + [mp.nstr(x, 25) for x in edges]), flush=True)
            if i % 50 == 49:
                print(kind, i + 1, file=sys.stderr)


if __name__ == "__main__":
    main()
