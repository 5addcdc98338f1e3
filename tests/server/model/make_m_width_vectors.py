#!/usr/bin/env python3
"""Writes tests/data/m_width_vectors.csv: M-widths of random loops, in 50-digit arithmetic.

    /usr/bin/python3 tests/server/model/make_m_width_vectors.py > tests/data/m_width_vectors.csv
    /usr/bin/python3 tests/server/model/make_m_width_vectors.py --check tests/data/m_width_vectors.csv

With --check it makes a few loops of each kind anew and fails where the file says anything else.
Needs mpmath (Debian: python3-mpmath; python3-gmpy2 makes it faster); takes some minutes. Shares nothing with the C++ code: the plant is
discretized by the matrix exponential, the open loop is evaluated as printed (eqs. 3 to 5), the zeros of its imaginary
part along the unit circle are bracketed on a grid and refined. Then the characteristic polynomial must confirm each
edge by the criterion of Schur and Cohn: all roots inside the circle at several masses up to (1 - 1e-15) of it, one
outside at (1 + 1e-15). A loop that fails this stops the script: no vector is written unconfirmed.
"""
import random
import sys

from mpmath import expm, findroot, log, matrix, mp, mpc, mpf, pi, polyroots, sqrt

mp.dps = 50
SEED = 20120709
NEAR = mpf(10) ** -15
FIELDS = (
    "device_mass,device_damping,hand_mass,hand_damping,hand_stiffness,period_s,cutoff_hz,delay_s,estimator,"
    "lower,upper,lower_hz,upper_hz"
)
# How many of each kind. Those of the other estimators are otherwise like "any".
COUNTS = {
    "any": 1500,
    "released": 180,
    "frictionless": 60,
    "with_hand_mass": 100,
    "slow": 150,
    "heavily_damped": 150,
    "late-filtered-difference": 60,
    "butterworth": 150,
    "kalman": 150,
}
ESTIMATORS = ("late-filtered-difference", "butterworth", "kalman")
# --check makes one in so many of each kind anew, the first included.
CHECK_STRIDE = 300


def log_uniform(rng, low, high):
    return low * (high / low) ** rng.random()


def random_loop(rng, kind):
    """(m, b, m_h, b_h, k_h, T, f0, delay) as doubles, and the estimator."""
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
    estimator = kind if kind in ESTIMATORS else "filtered-difference"
    return mass, damping, hand_mass, hand_damping, stiffness, period, cutoff, delay, estimator


def times(p, q):
    """Product of polynomials, highest power first."""
    product = [mpf(0)] * (len(p) + len(q) - 1)
    for i, x in enumerate(p):
        for j, y in enumerate(q):
            product[i + j] += x * y
    return product


def plus(p, q):
    """Sum of polynomials, highest power first."""
    length = max(len(p), len(q))
    return [x + y for x, y in zip([mpf(0)] * (length - len(p)) + p, [mpf(0)] * (length - len(q)) + q)]


def low_pass(estimator, ticks_per_turn):
    """Numerator and denominator of the filter behind the double difference; its cut-off in samples a period."""
    if estimator == "butterworth":
        # Bilinear transform of 1/(s^2 + sqrt(2) s + 1), prewarped: s = (z - 1)/(g (z + 1)).
        g = mp.tan(pi / ticks_per_turn)
        minus, sum_ = [mpf(1), mpf(-1)], [mpf(1), mpf(1)]
        gained = [g * x for x in sum_]
        middle = [sqrt(mpf(2)) * x for x in times(minus, gained)]
        return times(gained, gained), plus(plus(times(minus, minus), middle), times(gained, gained))
    if estimator == "kalman":
        # Poles: the stable half of the symmetric root locus u^3 + lambda^2 (1 - u/4) = 0, u = 2 - z - 1/z, with
        # the tracking index that puts the filter 3 dB down at the cut-off; gain 1 at standstill.
        u_cutoff = 2 - 2 * mp.cos(2 * pi / ticks_per_turn)
        index_squared = u_cutoff**3 / (1 + u_cutoff / 4)
        denominator = [mpf(1)]
        for u in polyroots([mpf(1), 0, -index_squared / 4, index_squared], maxsteps=500, extraprec=400):
            pole = min(polyroots([mpf(1), u - 2, mpf(1)], maxsteps=500, extraprec=400), key=abs)
            denominator = times(denominator, [mpf(1), -pole])
        denominator = [x.real for x in denominator]
        return [sum(denominator), mpf(0), mpf(0), mpf(0)], denominator
    a = mp.exp(-2 * pi / ticks_per_turn)
    late = estimator == "late-filtered-difference"
    return [1 - a] if late else [1 - a, mpf(0)], [mpf(1), -a]


class Loop:
    def __init__(self, mass, damping, hand_mass, hand_damping, stiffness, period, cutoff, delay, estimator):
        self.mu = mpf(mass) + mpf(hand_mass)
        self.beta = mpf(damping) + mpf(hand_damping)
        self.k = mpf(stiffness)
        self.period = mpf(period)
        self.low_pass = low_pass(estimator, 1 / (mpf(cutoff) * self.period))
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
        filtered = mp.polyval(self.low_pass[0], z) / mp.polyval(self.low_pass[1], z)
        plant = mp.polyval(self.numerator, z) / mp.polyval(self.denominator, z) / z ** (self.whole + 1)
        return double_difference * filtered * plant

    def stable(self, mass):
        """True where all closed-loop poles are inside the unit circle, by the recursion of Schur and Cohn; poles at
        z = 1 of a released hand, which the double difference hides, left out."""
        plant, square = self.denominator, [mpf(1), mpf(-2), mpf(1)]
        if self.k == 0:
            plant, square = [mpf(1), -mp.exp(-self.beta * self.period / self.mu)], [mpf(1), mpf(-1)]
            if self.beta == 0:
                plant, square = [mpf(1)], [mpf(1)]
        filtered, low_pass_poles = self.low_pass
        # Powers of z below: two of the double difference, one of the hold, the delay.
        left = times(times(plant, low_pass_poles), [mpf(1)] + [mpf(0)] * (self.whole + 3))
        gain = mpf(mass) / self.period**2
        total = plus(left, [gain * x for x in times(times(square, self.numerator), filtered)])
        with mp.workdps(120):
            while len(total) > 1:
                reflection = total[-1] / total[0]
                if abs(reflection) >= 1:
                    return False
                total = [x - reflection * y for x, y in zip(total[:-1], reversed(total))]
        return True

    def crossings(self):
        """(mass, angle) wherever the open loop is real on the circle."""
        def imaginary(angle):
            return self.open_loop(mp.expj(angle)).imag

        grid = [mp.exp(log(mpf(10) ** -8) + i * (log(pi) - log(mpf(10) ** -8)) / 500) for i in range(500)]
        grid += [pi * i / 200 for i in range(1, 200)]
        half_trace, determinant = -self.denominator[1] / 2, self.denominator[2]
        for sign in (-1, 1):
            pole = half_trace + sign * sqrt(mpc(half_trace**2 - determinant))
            angle, width = abs(mp.arg(pole)), abs(log(abs(pole)))
            grid += [angle + side * width * mpf(2) ** i for side in (-1, 1) for i in range(-40, 8)]
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
        for share in (mpf("0.01"), mpf("0.1"), mpf("0.5"), mpf("0.9"), 1 - NEAR):
            assert self.stable(edge * share)
        assert not self.stable(edge * (1 + NEAR))

    def m_width(self):
        self.prepare()
        crossings = self.crossings()
        lower = max(c for c in crossings if c[0] < 0)
        upper = min(c for c in crossings if c[0] > 0)
        self.confirm(lower[0])
        self.confirm(upper[0])
        hz = [c[1] / (2 * pi * self.period) for c in (lower, upper)]
        return lower[0], upper[0], hz[0], hz[1]


def vector(kind, number):
    """One line of the file."""
    loop = random_loop(random.Random(f"{SEED} {kind} {number}"), kind)
    try:
        edges = Loop(*loop).m_width()
    except AssertionError:
        sys.exit(f"not confirmed: {kind} {loop}")
    return ",".join([*(repr(x) for x in loop[:-1]), loop[-1], *(mp.nstr(x, 25) for x in edges)])


def main():
    numbers = [(kind, number) for kind, count in COUNTS.items() for number in range(count)]
    if sys.argv[1:2] == ["--check"]:
        with open(sys.argv[2], encoding="ascii") as file:
            stored = file.read().split()
        assert stored[0] == FIELDS and len(stored) == 1 + len(numbers), f"not {len(numbers)} loops of {FIELDS}"
        for line, (kind, number) in zip(stored[1:], numbers):
            if number % CHECK_STRIDE == 0:
                made = vector(kind, number)
                assert line == made, f"stored: {line}\nmade:   {made}"
        return
    print(FIELDS)
    for kind, number in numbers:
        print(vector(kind, number), flush=True)


if __name__ == "__main__":
    main()
