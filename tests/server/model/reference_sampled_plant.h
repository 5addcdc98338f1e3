// The sampled plant by states, in 50 digits: what the closed forms are held against.
#pragma once

#include <array>

#include "server/model/loop_parameters.h"
#include "tests/server/model/reference_plant.h"

namespace mwidth::model {

/// The quantities of SampledPlant.
struct ReferenceSampledPlant {
  Real gain;
  std::array<Real, 3> hold;
  int delay_ticks;
  Real static_gap;
  Real loss;
};

/// Eq. 10: the numerator is the first row of adj(z - A) times what the two forces that act within one tick
/// leave at its end, A = e^(A_c T).
inline ReferenceSampledPlant DiscretizeIn50Digits(const LoopParameters& loop) {
  const Matrix generator = Generator(loop);
  const Real period = loop.period_s;
  const Real ticks = Real(loop.delay_s) / period;
  const Real fraction = ticks - floor(ticks);
  const Matrix a = Exponential(generator, period);
  const Matrix late = Exponential(generator, (1 - fraction) * period);
  const Real gain = period * period / (Real(loop.device_mass) + Real(loop.hand_mass));
  // The generator counts force against the position.
  const std::array<Real, 2> newer{-late[0][2] / gain, -late[1][2] / gain};
  const std::array<Real, 2> older{-a[0][2] / gain - newer[0], -a[1][2] / gain - newer[1]};
  const Real determinant = a[0][0] * a[1][1] - a[0][1] * a[1][0];
  return {.gain = gain,
          .hold = {newer[0], -a[1][1] * newer[0] + a[0][1] * newer[1] + older[0],
                   -a[1][1] * older[0] + a[0][1] * older[1]},
          .delay_ticks = static_cast<int>(floor(ticks)),
          .static_gap = 1 - a[0][0] - a[1][1] + determinant,
          .loss = 1 - determinant};
}

}  // namespace mwidth::model
