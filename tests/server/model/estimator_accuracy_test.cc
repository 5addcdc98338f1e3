// Perceived mass and force noise with every estimator.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "server/model/accelerometer_simulation.h"
#include "server/model/accuracy.h"
#include "server/model/estimator.h"
#include "server/model/force_noise.h"
#include "server/model/frequency_response.h"
#include "server/model/m_width.h"
#include "tests/server/model/model_loops.h"

namespace mwidth::model {
namespace {

// Table II with each estimator; accelerometers of 150 Hz.
std::vector<LoopParameters> OneOfEach() {
  std::vector<LoopParameters> loops;
  const auto add = [&loops](EstimatorKind kind) {
    LoopParameters loop = TableTwo();
    loop.estimator = kind;
    loop.accelerometer_bandwidth_hz = 150;
    loops.push_back(loop);
  };
  std::for_each(kEstimatorKinds.begin(), kEstimatorKinds.end(), add);
  std::for_each(kAccelerometerKinds.begin(), kAccelerometerKinds.end(), add);
  return loops;
}

TEST(EveryEstimator, IsPredictedAsAccurateAsItIsMeasured) {
  RandomLoops random(71);
  for (const LoopParameters& each : OneOfEach()) {
    for (int i = 0; i < 8; ++i) {
      LoopParameters loop = random.Next();
      // A chirp of a minute resolves no sharper resonance, and a test no shorter period.
      loop.period_s = random.LogUniform(5e-4, 5e-3);
      loop.cutoff_hz = random.LogUniform(2, 0.4 / loop.period_s);
      loop.delay_s = i % 2 == 0 ? 0 : random.Uniform(0, 3) * loop.period_s;
      loop.hand_damping = random.LogUniform(0.3, 1) * std::sqrt(loop.hand_stiffness * loop.device_mass);
      loop.estimator = each.estimator;
      loop.accelerometer_bandwidth_hz = random.LogUniform(20, 2000);
      const MWidth m_width = ComputeMWidth(loop);
      const double least = std::max(0.5 * m_width.lower.mass, -10 * loop.device_mass);
      const double mass = random.Uniform(least, std::min(0.5 * m_width.upper.mass, 10 * loop.device_mass));
      for (const TickInstant instant : {TickInstant::kBeforeForceStep, TickInstant::kAfterForceStep}) {
        const PerceivedMass predicted = PredictPerceivedMass(loop, mass, {}, instant);
        const PerceivedMass measured = MeasurePerceivedMass(loop, mass, {}, instant);
        ASSERT_EQ(predicted.perception, Perception::kKnown);
        ASSERT_EQ(measured.perception, Perception::kKnown);
        EXPECT_NEAR(predicted.mass, measured.mass, 0.01 * (loop.device_mass + std::abs(mass)))
            << Name(loop.estimator) << " " << i;
      }
    }
  }
}

TEST(EveryEstimator, RendersSlowMotionsAlmostTruly) {
  const MotionBand slow{.lowest_hz = 0.05, .highest_hz = 0.1, .duration_s = 60};
  for (const LoopParameters& loop : OneOfEach()) {
    const PerceivedMass perceived = PredictPerceivedMass(loop, 0.07, slow);
    ASSERT_EQ(perceived.perception, Perception::kKnown);
    EXPECT_NEAR(perceived.error.value(), 0, 1e-3) << Name(loop.estimator);
  }
}

// The mean square of a force spectrum per unit of white noise: midpoints over half the circle, dense in
// frequency and in its logarithm, t = pi e^-y, y to 25.
template <typename Spectrum>
double RootMeanSquare(const LoopParameters& loop, const Spectrum& spectrum) {
  constexpr int kSteps = 100000;
  constexpr double kDepth = 25;
  double sum = 0;
  for (int k = 0; k < kSteps; ++k) {
    const double share = std::exp(-(k + 0.5) * kDepth / kSteps);
    sum += std::norm(spectrum(share / (2 * loop.period_s))) * share;
  }
  return std::sqrt(sum * kDepth / kSteps);
}

TEST(EveryEstimator, FromPositionsHasTheNoiseOfItsSpectrum) {
  constexpr double kQuantum = 1e-6;
  RandomLoops random(72);
  for (const EstimatorKind kind : kEstimatorKinds) {
    for (int i = 0; i < 5; ++i) {
      LoopParameters loop = random.Next();
      loop.estimator = kind;
      loop.cutoff_hz = std::min(loop.cutoff_hz, 0.45 / loop.period_s);
      const MWidth m_width = ComputeMWidth(loop);
      const double mass = random.Uniform(0.9 * m_width.lower.mass, 0.9 * m_width.upper.mass);
      const SampledResponse sampled(loop);
      const LinearEstimator estimator = EstimatorOf(loop);
      const double expected = RootMeanSquare(loop, [&](double frequency_hz) {
        return mass * estimator.Response(AtFrequency(frequency_hz, loop.period_s)) /
               (1.0 + sampled.Loop(mass, frequency_hz));
      });
      EXPECT_NEAR(*ForceNoise(loop, mass, kQuantum) / (kQuantum * expected / std::sqrt(12)), 1, 1e-6)
          << Name(kind) << " " << i;
    }
  }
}

TEST(EveryEstimator, WithAnAccelerometerHasTheNoiseOfItsSpectrum) {
  RandomLoops random(73);
  for (const EstimatorKind kind : kAccelerometerKinds) {
    for (int i = 0; i < 8; ++i) {
      LoopParameters loop = random.Next();
      loop.estimator = kind;
      loop.accelerometer_bandwidth_hz = random.LogUniform(0.01, 1) / loop.period_s;
      // No sharper resonance, which the sum below would miss.
      loop.hand_damping += 0.1 * std::sqrt(loop.hand_stiffness * (loop.device_mass + loop.hand_mass));
      if (i == 0) {
        loop.hand_damping = loop.hand_stiffness = 0;
      }
      const MWidth m_width = ComputeMWidth(loop);
      const double mass = random.Uniform(0.7 * m_width.lower.mass, 0.7 * m_width.upper.mass);
      const SampledResponse sampled(loop);
      const LinearEstimator filter = AccelerometerFilter(loop);
      const double expected = RootMeanSquare(loop, [&](double frequency_hz) {
        return mass * filter.Response(AtFrequency(frequency_hz, loop.period_s)) /
               (1.0 + sampled.Loop(mass, frequency_hz));
      });
      // Of a pole 1e-7 from z = 1, beside others that are far, Routh's table keeps no more.
      EXPECT_NEAR(*AccelerometerForceNoise(loop, mass, 0.3) / (0.3 * expected), 1, 1e-4)
          << Name(kind) << " " << i;
      EXPECT_EQ(ForceNoise(loop, mass, 1e-6), 0);
      EXPECT_FALSE(AccelerometerForceNoise(loop, 1.001 * m_width.upper.mass, 0.3));
      EXPECT_FALSE(ForceNoise(loop, 1.001 * m_width.upper.mass, 1e-6));
    }
  }
}

constexpr int kTicks = 200000;
constexpr int kSettled = 4000;

// The standard deviation of what an encoder of this quantum adds to the commanded force.
double SimulatedNoise(const LoopParameters& loop, double mass, double quantum) {
  HybridSimulation exact(loop);
  HybridSimulation counted(loop);
  AccelerationEstimator exact_estimator(loop.period_s, loop.cutoff_hz, loop.estimator);
  AccelerationEstimator counted_estimator = exact_estimator;
  double sum_of_squares = 0;
  for (int k = 0; k < kTicks; ++k) {
    const double force = mass * exact_estimator.Update(exact.position());
    const double noisy = mass * counted_estimator.Update(quantum * std::round(counted.position() / quantum));
    sum_of_squares += k >= kSettled ? (noisy - force) * (noisy - force) : 0;
    exact.Command(force);
    counted.Command(noisy);
    // A sway of many counts a tick at frequencies without a common period, so that no count repeats.
    const double t = (k + 1) * loop.period_s;
    const double hand =
        0.05 * (std::sin(2 * std::numbers::pi * 0.731 * t) + std::sin(2 * std::numbers::pi * 1.618 * t + 1));
    exact.Advance(hand);
    counted.Advance(hand);
  }
  return std::sqrt(sum_of_squares / (kTicks - kSettled));
}

// The standard deviation of the force that white noise on the accelerometer's samples causes at rest.
double SimulatedSensorNoise(const LoopParameters& loop, double mass, double deviation) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0, deviation);
  AccelerometerSimulation device(loop);
  FirstOrderLowPass filter(FirstOrderLowPass::Factors(loop.period_s, loop.cutoff_hz));
  double sum_of_squares = 0;
  for (int k = 0; k < kTicks; ++k) {
    const double sample = device.sensed() + noise(random);
    const double force =
        mass * (loop.estimator == EstimatorKind::kAccelerometer ? sample : filter.Update(sample));
    sum_of_squares += k >= kSettled ? force * force : 0;
    device.Command(force);
    device.Advance(0);
  }
  return std::sqrt(sum_of_squares / (kTicks - kSettled));
}

TEST(EveryEstimator, HasTheNoiseOfItsSimulation) {
  for (LoopParameters loop : OneOfEach()) {
    for (const double delay_ticks : {0.0, 1.4}) {
      loop.delay_s = delay_ticks * loop.period_s;
      const MWidth m_width = ComputeMWidth(loop);
      for (const double mass : {0.5 * m_width.lower.mass, 0.8 * m_width.upper.mass}) {
        const double simulated = IsAccelerometer(loop.estimator) ? SimulatedSensorNoise(loop, mass, 0.2)
                                                                 : SimulatedNoise(loop, mass, 1e-6);
        const double predicted = IsAccelerometer(loop.estimator) ? *AccelerometerForceNoise(loop, mass, 0.2)
                                                                 : *ForceNoise(loop, mass, 1e-6);
        EXPECT_NEAR(simulated / predicted, 1, 0.04) << Name(loop.estimator) << " " << mass;
      }
    }
  }
}

}  // namespace
}  // namespace mwidth::model
