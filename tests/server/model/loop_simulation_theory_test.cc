// Each imperfection alone, against what it must do by theory.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/model/loop_simulation.h"
#include "server/model/m_width.h"
#include "tests/server/model/model_loops.h"
#include "tests/server/model/sweeping_hand.h"

namespace mwidth::model {
namespace {

/// Sum over all ticks of |response of x to a position misread once by 1|: no sequence of misreadings of at
/// most e moves the device by more than e times this.
double LargestGainFromReading(const LoopParameters& loop, double mass) {
  HybridSimulation plant(loop);
  AccelerationEstimator estimator(loop.period_s, loop.cutoff_hz);
  estimator.Reset(0);
  double sum = 0;
  for (int tick = 0; tick < 20'000; ++tick) {
    const double misread = tick == 0 ? 1 : 0;
    plant.Command(mass * estimator.Update(plant.position() + misread));
    sum += std::abs(plant.Advance(0));
  }
  EXPECT_LT(std::abs(plant.position()), 1e-12 * sum) << "not faded yet";
  return sum;
}

TEST(LoopSimulationTheory, EncoderMovesTheDeviceNoFurtherThanItsGainAllows) {
  const double quantum = 20e-6;
  for (const double mass_ratio : {-1.2, -0.5, 3.0, 25.0}) {
    const double mass = mass_ratio * 0.07;
    const double bound = quantum / 2 * LargestGainFromReading(TableTwo(), mass);
    LoopSimulation exact(TableTwo(), mass);
    LoopSimulation counted(TableTwo(), mass, {.position_quantum = quantum});
    double apart = 0;
    for (int tick = 0; tick < 5000; ++tick) {
      const double hand = SweepingHand(tick);
      apart = std::max(apart, std::abs(exact.Step(hand).position - counted.Step(hand).position));
    }
    EXPECT_LE(apart, bound) << mass_ratio;
    EXPECT_GT(apart, bound / 1000) << mass_ratio;
  }
}

TEST(LoopSimulationTheory, EncoderKeepsABoundedLimitCycleAliveUnderAHandAtRest) {
  // Close to its edge the ideal loop rings down; one that reads counts is kept ringing by their edges.
  const double mass = 0.98 * ComputeMWidth(TableTwo()).upper.mass;
  const double quantum = 20e-6;
  const double bound = quantum / 2 * LargestGainFromReading(TableTwo(), mass);
  const Imperfections encoder{.position_quantum = quantum};
  double exact_swing = 0;
  double counted_swing = 0;
  LoopSimulation exact(TableTwo(), mass);
  LoopSimulation counted(TableTwo(), mass, encoder);
  for (auto* simulation : {&exact, &counted}) {
    simulation->Reset(0.5 * quantum, 0.1, 0.5 * quantum);
  }
  for (int tick = 0; tick < 40'000; ++tick) {
    const double exact_offset = std::abs(exact.Step(0.5 * quantum).position - 0.5 * quantum);
    const double counted_offset = std::abs(counted.Step(0.5 * quantum).position - 0.5 * quantum);
    if (tick >= 35'000) {
      exact_swing = std::max(exact_swing, exact_offset);
      counted_swing = std::max(counted_swing, counted_offset);
    }
  }
  EXPECT_LT(exact_swing, 1e-12);
  EXPECT_GT(counted_swing, 0.01 * quantum);
  EXPECT_LE(counted_swing, bound + exact_swing);
}

TEST(LoopSimulationTheory, SaturationHoldsAnUnstableLoopAtTheAmplitudeOfTheDescribingFunction) {
  // A sine of amplitude A through a limit F keeps 2/pi (asin(F/A) + F/A sqrt(1 - F^2/A^2)) of its size; the
  // loop swings where that takes the mass back to its edge (Slotine and Li, Applied Nonlinear Control, 1991).
  // At the lower edge: the upper one's 262 Hz would lock onto four ticks.
  const Edge edge = ComputeMWidth(TableTwo()).lower;
  const double mass = 1.25 * edge.mass;
  const double limit = 2;
  LoopSimulation simulation(TableTwo(), mass, {.force_limit = limit});
  simulation.Reset(0, 0.01, 0);
  double amplitude = 0;
  int rising = 0;
  double before = 0;
  constexpr int kTicks = 20'000;
  for (int tick = 0; tick < 2 * kTicks; ++tick) {
    const double wanted = mass * simulation.Step(0).acceleration;
    if (tick >= kTicks) {
      amplitude = std::max(amplitude, std::abs(wanted));
      rising += before < 0 && wanted >= 0 ? 1 : 0;
    }
    before = wanted;
  }
  const double share = limit / amplitude;
  const double kept = 2 / std::numbers::pi * (std::asin(share) + share * std::sqrt(1 - share * share));
  // It neglects harmonics, which this loop damps to less than a percent.
  EXPECT_NEAR(kept, 1 / 1.25, 0.01);
  EXPECT_NEAR(rising / (kTicks * 1e-3), edge.critical_hz, 0.01 * edge.critical_hz);
}

TEST(LoopSimulationTheory, FrictionHoldsTheDeviceThatAWeakHandPulls) {
  LoopSimulation simulation(TableTwo(), 0.1, {.coulomb_friction = 1.4});
  simulation.Reset(0, 0, 0.0019);
  for (int tick = 0; tick < 100; ++tick) {
    const LoopSample sample = simulation.Step(0.0019);  // 700 N/m: 1.33 N
    EXPECT_EQ(sample.position, 0);
    EXPECT_EQ(sample.force, 0);
  }
  EXPECT_NEAR(simulation.Step(0.0019).hand_force, 1.33, 1e-12);
  simulation.Reset(0, 0, 0.0021);  // 1.47 N
  simulation.Step(0.0021);
  EXPECT_GT(simulation.Step(0.0021).position, 0);
}

TEST(LoopSimulationTheory, FrictionBringsALoopBeyondItsEdgeToRestFromASmallPush) {
  const double mass = 1.01 * ComputeMWidth(TableTwo()).upper.mass;
  LoopSimulation ideal(TableTwo(), mass);
  LoopSimulation rough(TableTwo(), mass, {.coulomb_friction = 0.1});
  double ideal_swing = 0;
  for (auto* simulation : {&ideal, &rough}) {
    simulation->Reset(0, 1e-3, 0);
  }
  double velocity = 1;
  for (int tick = 0; tick < 5000; ++tick) {
    ideal_swing = std::max(ideal_swing, std::abs(ideal.Step(0).velocity));
    velocity = rough.Step(0).velocity;
  }
  EXPECT_GT(ideal_swing, 1);
  EXPECT_EQ(velocity, 0);
}

}  // namespace
}  // namespace mwidth::model
