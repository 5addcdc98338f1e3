#include "server/model/edge_crossing.h"

#include <cmath>
#include <limits>

namespace mwidth::model {
namespace {

// The paper's estimator, no delay, a sampling that does not alias the natural frequency (there n1 > 0), and
// neither a filter nor a damping so slow that a product below would underflow. Without damping the lower edge
// is at rest and Z is 0.
bool HasClosedForm(const SampledPlant& plant, const EstimatorFactors& estimator) noexcept {
  constexpr double kLeast = 1e-70;
  return estimator.pole_count == 1 && estimator.poles[0].degree == 1 && estimator.lag_ticks == 1 &&
         estimator.gain > kLeast && plant.delay_ticks == 0 && plant.hold[2] == 0 && plant.hold[1] > 0 &&
         plant.loss > kLeast;
}

EdgeCrossings ClosedForm(const SampledPlant& plant, const EstimatorFactors& estimator,
                         double moving_mass) noexcept {
  const double f = estimator.poles[0].circle.at_c;
  const double a = estimator.poles[0].circle.turn;
  const double q = plant.static_gap;
  const double delta = plant.loss;
  const double n0 = plant.hold[0];
  const double n1 = plant.hold[1];

  const double p = n0 + n1 + f * n1;
  const double h = n1 + a * n0;
  const double e = n1 * (q + delta);
  const double z = q * p + delta * f * (n0 + n1);
  const double difference = p - e;
  const double turned = 4 * n1 * delta * h;
  const double root = std::sqrt(difference * difference + turned);
  const double r = difference >= 0 ? 0.5 * (difference + root) : 0.5 * turned / (root - difference);
  const double s = r + e;

  EdgeCrossings edges;
  edges.lower = {.mass = -moving_mass * delta * (f * f * s + a * z) / (f * z * r),
                 .half_sine_squared = z / (4 * s)};
  if (s < 4 * n1) {
    edges.upper = {.mass = moving_mass * r * (f * f * n1 + a * s) / (f * n1 * h * s),
                   .half_sine_squared = s / (4 * n1)};
  } else {
    edges.upper = {.mass = moving_mass * (4 - q - 2 * delta) * (1 + a) / (4 * f * (n0 - n1)),
                   .half_sine_squared = 1};
  }
  return edges;
}

}  // namespace

EdgeCrossings NearestToZero(const Crossings& crossings) noexcept {
  EdgeCrossings edges{.lower = {.mass = -std::numeric_limits<double>::infinity()},
                      .upper = {.mass = std::numeric_limits<double>::infinity()}};
  for (const Crossing& crossing : crossings) {
    if (crossing.mass > 0 && crossing.mass < edges.upper.mass) {
      edges.upper = crossing;
    } else if (crossing.mass < 0 && crossing.mass > edges.lower.mass) {
      edges.lower = crossing;
    }
  }
  return edges;
}

EdgeCrossings FindEdgeCrossings(const SampledPlant& plant, const EstimatorFactors& estimator,
                                double moving_mass) noexcept {
  return HasClosedForm(plant, estimator) ? ClosedForm(plant, estimator, moving_mass)
                                         : NearestToZero(FindCrossings(plant, estimator, moving_mass));
}

}  // namespace mwidth::model
