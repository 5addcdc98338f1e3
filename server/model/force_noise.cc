#include "server/model/force_noise.h"

#include <cmath>
#include <cstddef>

#include "server/model/accelerometer.h"
#include "server/model/m_width.h"
#include "server/model/plant.h"
#include "server/model/white_noise_gain.h"

namespace mwidth::model {
namespace {

std::optional<double> Deviation(const DifferencePolynomial& numerator,
                                const DifferencePolynomial& denominator, double position_quantum) {
  const std::optional<double> gain = WhiteNoiseGain(numerator, denominator);
  return gain ? std::optional(position_quantum * std::sqrt(*gain / 12)) : std::nullopt;
}

DifferencePolynomial Scaled(DifferencePolynomial polynomial, double factor) {
  for (double& coefficient : polynomial) {
    coefficient *= factor;
  }
  return polynomial;
}

DifferencePolynomial Sum(DifferencePolynomial longer, const DifferencePolynomial& shorter) {
  for (std::size_t i = 0; i < shorter.size(); ++i) {
    longer[i] += shorter[i];
  }
  return longer;
}

// G(z) z^-delay of plant.h as polynomials in w = z - 1.
struct Plant {
  DifferencePolynomial numerator;
  DifferencePolynomial denominator;
};

Plant InDifferences(const SampledPlant& plant) {
  const auto& n = plant.hold;
  const double q = plant.static_gap;
  Plant result{.numerator = {plant.gain * (n[0] + n[1]), plant.gain * n[0]},
               .denominator = {q, q + plant.loss, 1}};
  int delays = plant.delay_ticks;
  if (n[2] != 0) {
    result.numerator = {plant.gain * (n[0] + n[1] + n[2]), plant.gain * (2 * n[0] + n[1]), plant.gain * n[0]};
    ++delays;
  }
  for (int i = 0; i < delays; ++i) {
    result.denominator = Multiply(result.denominator, {1, 1});
  }
  return result;
}

}  // namespace

std::optional<double> OpenLoopForceNoise(const LinearEstimator& estimator, double mass,
                                         double position_quantum) {
  return Deviation(Scaled(estimator.numerator, mass), estimator.denominator, position_quantum);
}

std::optional<double> ForceNoise(const LoopParameters& loop, double mass, double position_quantum,
                                 double acceleration_quantum) {
  if (IsAccelerometer(loop.estimator)) {
    return AccelerometerForceNoise(loop, mass, acceleration_quantum / std::sqrt(12));
  }
  // Beyond an edge the loop may be stable again, but no ramp of the mass gets there.
  if (!ComputeMWidth(loop).Contains(mass)) {
    return std::nullopt;
  }
  const LinearEstimator estimator = EstimatorOf(loop);
  const Plant plant = InDifferences(Discretize(loop));
  const DifferencePolynomial rendered = Scaled(estimator.numerator, mass);
  const DifferencePolynomial characteristic =
      Sum(Multiply(estimator.denominator, plant.denominator), Multiply(rendered, plant.numerator));
  return Deviation(Multiply(rendered, plant.denominator), characteristic, position_quantum);
}

std::optional<double> AccelerometerForceNoise(const LoopParameters& loop, double mass, double sample_noise) {
  if (!ComputeMWidth(loop).Contains(mass)) {
    return std::nullopt;
  }
  const SampledPlant plant = Discretize(loop);
  const SampledAcceleration acceleration = DiscretizeAcceleration(loop, plant);
  const LinearEstimator filter = AccelerometerFilter(loop);
  // Force to sensed acceleration.
  DifferencePolynomial denominator =
      Multiply({plant.static_gap, plant.static_gap + plant.loss, 1}, {acceleration.sensor.circle.at_c, 1});
  DifferencePolynomial numerator{0, acceleration.rise[0], acceleration.rise[1]};
  int delays = plant.delay_ticks;
  if (plant.hold[2] != 0) {
    numerator.push_back(acceleration.rise[2]);
    ++delays;
  }
  for (int i = 0; i < delays; ++i) {
    denominator = Multiply(denominator, {1, 1});
  }
  const DifferencePolynomial rendered = Scaled(filter.numerator, mass);
  const DifferencePolynomial feedback =
      Scaled(Multiply(rendered, numerator), 1 / (loop.device_mass + loop.hand_mass));
  const DifferencePolynomial characteristic = Sum(Multiply(filter.denominator, denominator), feedback);
  const std::optional<double> gain = WhiteNoiseGain(Multiply(rendered, denominator), characteristic);
  return gain ? std::optional(sample_noise * std::sqrt(*gain)) : std::nullopt;
}

}  // namespace mwidth::model
