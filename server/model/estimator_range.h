// The acceleration estimator on an arc of the unit circle: the one place where the bounds on a loop know
// which estimator it runs.
#pragma once

#include "server/model/estimator_factors.h"
#include "server/model/estimator_kind.h"
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

/// f/(w + f) with w = z - 1 and 0 < f <= 1: a first-order filter, 1 at standstill.
class FirstOrderRange {
 public:
  FirstOrderRange() = default;
  /// `gap` holds f, `pole` 1 - f.
  FirstOrderRange(const Interval& gap, const Interval& pole) noexcept : gap_(gap), pole_(pole) {}

  CircleRange Over(const Arc& arc) const noexcept;

 private:
  Interval gap_{};
  Interval pole_{};
};

/// B(1)/B for a factor of degree 2 of estimator_factors.h, times z: a second-order filter, 1 at standstill.
///
///   z conj(B) = p(x) - j turn sin(t), p linear in x      |B|^2 = p^2 + 4 x (1 - x) turn^2
///
/// Where the derivative has one sign over an arc, its ends bound the quotients by |B|^2; elsewhere interval
/// arithmetic does, on arcs that become short.
class SecondOrderRange {
 public:
  SecondOrderRange() = default;
  /// The coefficients of `factor`, which is of degree 2, are taken to be off by `ulps` units in the last
  /// place.
  SecondOrderRange(const PoleFactor& factor, double ulps) noexcept;

  CircleRange Over(const Arc& arc) const noexcept;

 private:
  Interval PAt(const Interval& x) const noexcept { return at_c_ + slope_ * x; }
  Interval SizeAt(const Interval& x) const noexcept {
    return Square(PAt(x)) + 4 * (x * (1 - x) * turn_squared_);
  }
  Interval SizeOver(const Interval& x) const noexcept;

  Interval at_c_{};
  /// p' = at_s - at_c.
  Interval slope_{};
  Interval turn_{};
  Interval turn_squared_{};
  /// |B|^2 = at_c^2 + linear_ x + square_ x^2.
  Interval linear_{};
  Interval square_{};
};

/// The estimator of a loop.
class EstimatorRange {
 public:
  /// Encloses the coefficients that the loop runs with, give or take 64 units in the last place.
  /// Precondition: what Validate asks of the estimator's numbers in loop_parameters.h.
  EstimatorRange(EstimatorKind kind, double period_s, double cutoff_hz,
                 double accelerometer_bandwidth_hz = 0) noexcept;

  /// Encloses -T^2 C(z)/u, which is 1 at standstill; of an accelerometer H(z) f_a/(w + f_a), likewise. Any
  /// thread.
  CircleRange Over(const Arc& arc) const noexcept;

  /// w_a T of an accelerometer; exactly 0 without one. Any thread.
  const Interval& sensor_rate() const noexcept { return sensor_rate_; }

 private:
  EstimatorKind kind_;
  FirstOrderRange first_order_;
  SecondOrderRange second_order_;
  FirstOrderRange sensor_;
  Interval sensor_rate_{};
};

}  // namespace mwidth::model
