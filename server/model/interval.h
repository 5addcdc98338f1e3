// Interval arithmetic: every result holds the exact result of every choice of arguments, rounding included.
//
// Each bound is computed in the processor's usual rounding and then moved outwards by two units in the last
// place, four after a function of the C library. That is wider than switching the rounding direction, by
// nothing that matters here, and needs no rounding mode that a compiler could reorder around. The C library's
// exp, expm1, sin and cos are documented to err by at most 2 units in the last place (the glibc manual's
// "Errors in Math Functions"); sqrt and the four operations by half of one (IEEE 754).
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace mwidth::model {

/// All real numbers from lo to hi; lo may be -infinity, hi infinity. Not empty: lo <= hi.
struct Interval {
  double lo = 0;
  double hi = 0;

  double width() const noexcept { return hi - lo; }
  double middle() const noexcept { return lo + (hi - lo) / 2; }
};

/// One number as an interval.
constexpr Interval Exactly(double x) noexcept { return {x, x}; }

/// Below x by at least one rounding of an operation with result x, also where the result is subnormal.
inline double Below(double x, double ulps = 2) noexcept {
  return x - (std::abs(x) * (ulps * std::numeric_limits<double>::epsilon()) + 1e-300);
}
/// Above x, likewise.
inline double Above(double x, double ulps = 2) noexcept { return -Below(-x, ulps); }

inline Interval operator-(const Interval& a) noexcept { return {-a.hi, -a.lo}; }
inline Interval operator+(const Interval& a, const Interval& b) noexcept {
  return {Below(a.lo + b.lo), Above(a.hi + b.hi)};
}
inline Interval operator-(const Interval& a, const Interval& b) noexcept { return a + -b; }
/// Both finite.
inline Interval operator*(const Interval& a, const Interval& b) noexcept {
  const double p = a.lo * b.lo;
  const double q = a.lo * b.hi;
  const double r = a.hi * b.lo;
  const double s = a.hi * b.hi;
  return {Below(std::min(std::min(p, q), std::min(r, s))), Above(std::max(std::max(p, q), std::max(r, s)))};
}
/// `b` above 0, both finite.
inline Interval operator/(const Interval& a, const Interval& b) noexcept {
  return {Below(a.lo / (a.lo < 0 ? b.lo : b.hi)), Above(a.hi / (a.hi < 0 ? b.hi : b.lo))};
}
inline Interval operator+(double a, const Interval& b) noexcept { return Exactly(a) + b; }
inline Interval operator-(double a, const Interval& b) noexcept { return Exactly(a) - b; }
inline Interval operator*(double a, const Interval& b) noexcept {
  const Interval product{Below(a * b.lo), Above(a * b.hi)};
  return a < 0 ? Interval{Below(a * b.hi), Above(a * b.lo)} : product;
}

inline Interval Square(const Interval& a) noexcept {
  const double low = a.lo > 0 ? a.lo : std::min(a.hi, 0.0);  // nearest to 0 unless 0 is inside
  const double high = std::max(-a.lo, a.hi);
  return {std::max(0.0, Below(a.lo <= 0 && a.hi >= 0 ? 0 : low * low)), Above(high * high)};
}
/// Of the part of `a` that is not negative.
inline Interval Sqrt(const Interval& a) noexcept {
  return {std::max(0.0, Below(std::sqrt(std::max(a.lo, 0.0)))), Above(std::sqrt(std::max(a.hi, 0.0)))};
}
inline Interval Exp(const Interval& a) noexcept {
  return {std::max(0.0, Below(std::exp(a.lo), 4)), Above(std::exp(a.hi), 4)};
}
/// The numbers of both; `a` and `b` meet.
inline Interval Meet(const Interval& a, const Interval& b) noexcept {
  return {std::max(a.lo, b.lo), std::min(a.hi, b.hi)};
}

/// (1 - e^-x) / x for x >= 0, 1 at 0: falls with x, from 1.
inline Interval MeanDecay(const Interval& x) noexcept {
  const auto at = [](double v) { return v == 0 ? 1 : -std::expm1(-v) / v; };
  return {std::max(0.0, Below(at(x.hi), 6)), std::min(1.0, Above(at(x.lo), 6))};
}

/// Range of a function of period 2 pi between its values at both ends, where it is 1 at `peak` and -1 half a
/// period on.
inline Interval Oscillation(const Interval& x, double at_lo, double at_hi, double peak) noexcept {
  constexpr double kPi = std::numbers::pi;
  constexpr double kSlack = 1e-9;  // an extremum this near counts as inside: far more than floor's rounding
  const double slack = kSlack * (1 + std::abs(x.hi));
  const double first = std::ceil((x.lo - slack - peak) / kPi);  // extrema are numbered from the peak
  const double last = std::floor((x.hi + slack - peak) / kPi);
  Interval range{std::max(-1.0, Below(std::min(at_lo, at_hi), 4)),
                 std::min(1.0, Above(std::max(at_lo, at_hi), 4))};
  if (first <= last) {
    const bool even = std::fmod(first, 2) == 0;
    const bool both = first < last;
    range.hi = even || both ? 1 : range.hi;
    range.lo = !even || both ? -1 : range.lo;
  }
  return range;
}
inline Interval Sin(const Interval& x) noexcept {
  return Oscillation(x, std::sin(x.lo), std::sin(x.hi), std::numbers::pi / 2);
}
inline Interval Cos(const Interval& x) noexcept { return Oscillation(x, std::cos(x.lo), std::cos(x.hi), 0); }

/// A rectangle of complex numbers.
struct ComplexInterval {
  Interval re;
  Interval im;
};
inline ComplexInterval operator*(const ComplexInterval& a, const ComplexInterval& b) noexcept {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}

}  // namespace mwidth::model
