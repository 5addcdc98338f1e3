// The mass held by a hand, as the sampled loop sees it behind the zero-order hold.
//
//   symbol   meaning                                        here
//   mu       moving mass m + m_h
//   beta     damping b + b_h
//   k        stiffness k_h
//   alpha    beta T / (2 mu), damping per tick
//   kappa    k T^2 / mu, stiffness per tick squared
//   h, Phi   impulse and step response of x'' + 2 alpha x' + kappa x, time in ticks
//   q        value of G's denominator at z = 1              static_gap
//   delta    1 - e^(-2 alpha), energy lost in a tick        loss
#pragma once

#include <array>

#include "server/model/loop_parameters.h"

namespace mwidth::model {

/// Zero-order-hold equivalent of 1/(mu s^2 + beta s + k) with loop delay, exact (eq. 10):
///
///   G(z) z^-delay = gain (hold[0] z^2 + hold[1] z + hold[2]) / (z^(1 + delay_ticks) (w^2 + (q + delta) w +
///   q))
///
/// with w = z - 1. The denominator is kept in w because its coefficients near z = 1 are what the slow poles
/// are made of; in powers of z they would drown in the rounding of 2 and 1. On the unit circle it equals (q -
/// |w|^2) z + delta w.
struct SampledPlant {
  /// T^2 / mu.
  double gain = 0;
  /// Share of the latest force, the one before and, with a fraction of a tick of delay, the one before that.
  std::array<double, 3> hold{};
  /// Whole ticks of delay, 0 to 3.
  int delay_ticks = 0;
  /// q, above 0; exactly 0 where the hand is released (k = 0).
  double static_gap = 0;
  /// delta, 0 to 1; exactly 0 where there is no damping.
  double loss = 0;
};

/// Every coefficient to a few units in the last place, for any damping from none to 1e4 per tick and any
/// stiffness; where the sampling aliases the natural frequency, as accurate as the cosine of that many
/// radians can be. Precondition: Validate(loop) is empty. Any thread. Rt.
SampledPlant Discretize(const LoopParameters& loop) noexcept;

}  // namespace mwidth::model
