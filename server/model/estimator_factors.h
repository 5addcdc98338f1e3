// The transfer function of an estimator of acceleration, by its factors: nothing expanded, so nothing cancels
// near z = 1, where slow poles lie.
#pragma once

#include <array>

#include "server/model/unit_circle.h"

namespace mwidth::model {

/// A polynomial B in w = z - 1 of degree 1 or 2 with real coefficients, by what it is on the unit circle:
///
///   z conj(B) = at_c c + at_s s - j turn sin(t)          c = cos^2(t/2), s = sin^2(t/2)
///
/// at_c is B at standstill, -at_s is B at half the sample rate:
///
///   degree 1   B = turn w + at_c (w + 1)                                  at_s = at_c + 2 turn
///   degree 2   B = (at_c + 2 turn - at_s)/4 w^2 + (at_c + turn) w + at_c
struct PoleFactor {
  int degree = 1;
  CircleFactor circle;

  /// Coefficients of w^0, w^1 and w^2.
  constexpr std::array<double, 3> Coefficients() const noexcept {
    if (degree == 1) {
      return {circle.at_c, circle.at_c + circle.turn, 0};
    }
    return {circle.at_c, circle.at_c + circle.turn, (circle.at_c + 2 * circle.turn - circle.at_s) / 4};
  }
  /// |B|^2 at a point of the unit circle.
  constexpr double SizeSquared(const CirclePoint& at) const noexcept {
    const double real = circle.at_c * at.c + circle.at_s * at.s;
    return real * real + circle.turn * circle.turn * 4 * at.s * at.c;
  }
};

/// Sampled position to estimated acceleration:
///
///   C(z) = gain w^2 (z + 1)^(2 half_rate_zero_pairs) / (T^2 z^lag_ticks B_0 B_1 ..)
///
/// All roots of the B are inside the unit circle, and C(z) tends to w^2/T^2 at standstill.
struct EstimatorFactors {
  static constexpr int kMaxPoles = 2;

  double gain = 0;
  /// Pairs of zeros at half the sample rate.
  int half_rate_zero_pairs = 0;
  /// Powers of 1/z; negative where the numerator has them.
  int lag_ticks = 0;
  int pole_count = 0;
  std::array<PoleFactor, kMaxPoles> poles{};

  const PoleFactor* begin() const noexcept { return poles.data(); }
  const PoleFactor* end() const noexcept { return poles.data() + pole_count; }
};

}  // namespace mwidth::model
