#include "server/model/force_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "server/model/estimator.h"
#include "server/model/frequency_response.h"
#include "server/model/hybrid_simulation.h"
#include "server/model/m_width.h"
#include "tests/server/model/model_loops.h"

namespace mwidth::model {
namespace {

constexpr double kQuantum = 1e-6;

double OpenLoop(const LoopParameters& loop, double mass) {
  return *OpenLoopForceNoise(EstimatorOf(loop), mass, kQuantum);
}

// The standard deviation of what the quantum adds to the commanded force: the same motion once with counts
// and once without. In closed loop the counted positions are those that the noise has moved already.
double SimulatedNoise(const LoopParameters& loop, double mass, bool closed) {
  HybridSimulation exact(loop);
  HybridSimulation counted(loop);
  AccelerationEstimator exact_estimator(loop.period_s, loop.cutoff_hz);
  AccelerationEstimator counted_estimator(loop.period_s, loop.cutoff_hz);
  double sum_of_squares = 0;
  constexpr int kTicks = 400000;
  constexpr int kSettled = 4000;
  for (int k = 0; k < kTicks; ++k) {
    const double position = closed ? counted.position() : exact.position();
    const double force = mass * exact_estimator.Update(exact.position());
    const double noisy = mass * counted_estimator.Update(kQuantum * std::round(position / kQuantum));
    if (k >= kSettled) {
      sum_of_squares += (noisy - force) * (noisy - force);
    }
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

TEST(ForceNoise, OpenLoopHasTheClosedFormOfThePapersEstimator) {
  RandomLoops loops(3);
  for (int i = 0; i < 100; ++i) {
    const LoopParameters loop = loops.Next();
    const double f = -std::expm1(-2 * std::numbers::pi * loop.cutoff_hz * loop.period_s);
    const double expected = 2.5 * kQuantum / std::sqrt(12) * f / (loop.period_s * loop.period_s) *
                            std::sqrt(1 + (1 + f) * (1 + f) + f * f * f / (2 - f));
    EXPECT_NEAR(OpenLoop(loop, 2.5) / expected, 1, 1e-12);
    EXPECT_NEAR(OpenLoop(loop, -2.5) / expected, 1, 1e-12);
  }
}

TEST(ForceNoise, IsTheMeanSquareOfItsSpectrum) {
  RandomLoops loops(11);
  for (int i = 0; i < 30; ++i) {
    LoopParameters loop = loops.Next();
    const MWidth m_width = ComputeMWidth(loop);
    const double mass = loops.Uniform(0.9 * m_width.lower.mass, 0.9 * m_width.upper.mass);
    const SampledResponse sampled(loop);
    const LinearEstimator estimator = EstimatorOf(loop);
    // Midpoints over half the circle, dense in frequency and in its logarithm: t = pi e^-y, y to 25.
    constexpr int kSteps = 100000;
    constexpr double kDepth = 25;
    double sum = 0;
    for (int k = 0; k < kSteps; ++k) {
      const double share = std::exp(-(k + 0.5) * kDepth / kSteps);
      const double frequency_hz = share / (2 * loop.period_s);
      const std::complex<double> force = mass * estimator.Response(AtFrequency(frequency_hz, loop.period_s)) /
                                         (1.0 + sampled.Loop(mass, frequency_hz));
      sum += std::norm(force) * share;
    }
    const double expected = kQuantum * std::sqrt(sum * kDepth / kSteps / 12);
    EXPECT_NEAR(*ForceNoise(loop, mass, kQuantum) / expected, 1, 1e-6) << "loop " << i;
  }
}

TEST(ForceNoise, IsWhatAnEncoderCausesInSimulation) {
  LoopParameters loop = TableTwo();
  for (const double delay_s : {0.0, 1.4e-3}) {
    loop.delay_s = delay_s;
    const MWidth m_width = ComputeMWidth(loop);
    for (const double mass : {3 * loop.device_mass, -0.5 * loop.device_mass, 0.9 * m_width.upper.mass}) {
      EXPECT_NEAR(SimulatedNoise(loop, mass, true) / *ForceNoise(loop, mass, kQuantum), 1, 0.03) << mass;
      EXPECT_NEAR(SimulatedNoise(loop, mass, false) / OpenLoop(loop, mass), 1, 0.03) << mass;
    }
  }
}

TEST(ForceNoise, RingsNearAnEdgeAndNotInOpenLoop) {
  const LoopParameters loop = TableTwo();
  const MWidth m_width = ComputeMWidth(loop);
  for (const double edge : {m_width.lower.mass, m_width.upper.mass}) {
    const double small = *ForceNoise(loop, 1e-6 * edge, kQuantum);
    EXPECT_NEAR(small / OpenLoop(loop, 1e-6 * edge), 1, 1e-5);
    // At a fraction e short of the edge one mode decays at a rate in proportion to e.
    const double close = *ForceNoise(loop, (1 - 1e-6) * edge, kQuantum);
    const double closer = *ForceNoise(loop, (1 - 1e-8) * edge, kQuantum);
    EXPECT_NEAR(closer / close, 10, 0.1);
    EXPECT_FALSE(ForceNoise(loop, 1.000001 * edge, kQuantum));
  }
}

TEST(ForceNoise, GrowsWithTheQuantumAndIsNoneAtNoMass) {
  const LoopParameters loop = TableTwo();
  EXPECT_DOUBLE_EQ(*ForceNoise(loop, 0.1, 3e-6), 3 * *ForceNoise(loop, 0.1, 1e-6));
  EXPECT_EQ(*ForceNoise(loop, 0, 1e-6), 0);
  EXPECT_EQ(*ForceNoise(loop, 0.1, 0), 0);
}

TEST(ForceNoise, IsFiniteForAReleasedHand) {
  LoopParameters loop = TableTwo();
  loop.hand_damping = loop.hand_stiffness = 0;
  const double released = *ForceNoise(loop, 0.1, kQuantum);
  loop.hand_stiffness = 1e-9;
  EXPECT_NEAR(*ForceNoise(loop, 0.1, kQuantum) / released, 1, 1e-6);
  loop.hand_stiffness = loop.device_damping = 0;
  EXPECT_NEAR(*ForceNoise(loop, 0.1, kQuantum) / released, 1, 1e-3);
}

}  // namespace
}  // namespace mwidth::model
