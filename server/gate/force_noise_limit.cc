#include "server/gate/force_noise_limit.h"

#include <cmath>
#include <optional>

#include "server/model/force_noise.h"

namespace mwidth::gate {

bool Keeps(const ForceNoiseLimit& limit, const model::LoopParameters& loop, double mass) {
  const std::optional<double> noise =
      model::ForceNoise(loop, mass, limit.position_quantum, limit.acceleration_quantum);
  return noise && *noise <= limit.max_force_noise;
}

double NearestQuietMass(const ForceNoiseLimit& limit, const model::LoopParameters& loop, double mass) {
  if (Keeps(limit, loop, mass)) {
    return mass;
  }
  constexpr double kTolerance = 1e-9;
  double quiet = 0;
  double noisy = mass;
  while (std::abs(noisy - quiet) > kTolerance * std::abs(noisy)) {
    const double middle = quiet + (noisy - quiet) / 2;
    (Keeps(limit, loop, middle) ? quiet : noisy) = middle;
  }
  return quiet;
}

}  // namespace mwidth::gate
