// The acceleration estimator on an arc of the unit circle: the one place where the bounds on a loop know
// which estimator it runs.
#pragma once

#include "server/model/interval.h"

namespace mwidth::model {

/// Part of the unit circle z = e^(jt) by x = sin^2(t/2), from 0 at standstill to 1 at half the sample rate.
struct Arc {
  Interval x;
  Interval cosine;        ///< cos t = 1 - 2 x
  Interval sine_squared;  ///< sin^2(t) = 4 x (1 - x)

  /// Precondition: 0 <= x.lo <= x.hi <= 1.
  explicit Arc(const Interval& half_sine_squared) noexcept
      : x(half_sine_squared), cosine(1 - 2 * x), sine_squared(Meet(4 * (x * (1 - x)), 1 - Square(cosine))) {}

  /// True for z = 1 and for z = -1 alone, where everything is real.
  bool real() const noexcept { return x.lo == x.hi && (x.lo == 0 || x.lo == 1); }
};

/// Complex numbers re + j sin(t) im on an arc. Real rational functions of z have this shape, with re and im
/// rational in x: nothing oscillates, and nothing is lost at standstill or at half the sample rate.
struct CircleRange {
  Interval re;
  Interval im;
};

inline CircleRange Multiply(const CircleRange& a, const CircleRange& b, const Arc& arc) noexcept {
  return {a.re * b.re - arc.sine_squared * (a.im * b.im), a.re * b.im + a.im * b.re};
}

/// Double difference and first-order filter (eqs. 3, 4): -T^2 C(z)/u = f/(w + f), f = 1 - a, w = z - 1.
class FirstOrderRange {
 public:
  FirstOrderRange(double period_s, double cutoff_hz) noexcept;

  /// Encloses -T^2 C(z)/u, which is 1 at standstill. Any thread.
  CircleRange Over(const Arc& arc) const noexcept;

 private:
  /// f and a.
  Interval gap_;
  Interval pole_;
};

}  // namespace mwidth::model
