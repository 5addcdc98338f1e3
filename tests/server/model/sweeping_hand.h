// A motion of the hand for simulations.
#pragma once

#include <cmath>
#include <numbers>

namespace mwidth::model {

/// A hand that sweeps 20 mm to and fro, 1 Hz rising to 3 Hz.
inline double SweepingHand(int tick) {
  const double t = tick * 1e-3;
  return 0.02 * std::sin(2 * std::numbers::pi * t * (1 + 0.5 * t));
}

}  // namespace mwidth::model
