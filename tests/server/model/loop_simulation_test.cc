// Without imperfections the model itself, with counts the rendering loop, bit for bit; and what a force may
// be.
#include "server/model/loop_simulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <set>
#include <string>

#include "server/model/m_width.h"
#include "server/render/limits.h"
#include "tests/server/model/model_loops.h"
#include "tests/server/model/sweeping_hand.h"

namespace mwidth::model {
namespace {

TEST(LoopSimulation, WithoutImperfectionsIsTheHybridLoopBitForBit) {
  std::mt19937_64 random(2012);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int i = 0; i < 50; ++i) {
    LoopParameters loop = TableTwo();
    loop.device_mass = std::exp(uniform(-5, 3));
    loop.hand_stiffness = i % 5 == 0 ? 0 : std::exp(uniform(0, 9));
    loop.cutoff_hz = std::exp(uniform(0, 5));
    loop.delay_s = i % 3 == 0 ? 0 : uniform(0, 3) * loop.period_s;
    const double mass = uniform(-2, 30) * loop.device_mass;  // some of them unstable
    LoopSimulation simulation(loop, mass);
    HybridSimulation plant(loop);
    AccelerationEstimator estimator(loop.period_s, loop.cutoff_hz);
    for (int tick = 0; tick < 500; ++tick) {
      const double hand = SweepingHand(tick);
      const double estimate = estimator.Update(plant.position());
      ASSERT_TRUE(std::isfinite(estimate));
      const double stretch = plant.hand_position() - plant.position();
      const double hand_velocity = (hand - plant.hand_position()) / loop.period_s;
      const LoopSample sample = simulation.Step(hand);
      ASSERT_EQ(sample.position, plant.position()) << i << ", tick " << tick;
      ASSERT_EQ(sample.velocity, plant.velocity());
      ASSERT_EQ(sample.acceleration, estimate);
      ASSERT_EQ(sample.force, mass * estimate);
      ASSERT_EQ(sample.hand_force,
                loop.hand_stiffness * stretch + loop.hand_damping * (hand_velocity - plant.velocity()));
      plant.Command(mass * estimate);
      plant.Advance(hand);
    }
  }
}

TEST(LoopSimulation, WithAnAccelerometerIsItsHybridLoopBitForBit) {
  for (const EstimatorKind kind : kAccelerometerKinds) {
    LoopParameters loop = TableTwo();
    loop.estimator = kind;
    loop.accelerometer_bandwidth_hz = 120;
    loop.delay_s = 1.3e-3;
    const double mass = 0.5 * ComputeMWidth(loop).upper.mass;
    LoopSimulation simulation(loop, mass);
    LoopSimulation counted(loop, mass, {.acceleration_quantum = 0.5});
    AccelerometerSimulation plant(loop);
    AccelerationEstimator estimator(loop.period_s, loop.cutoff_hz, kind);
    for (int tick = 0; tick < 500; ++tick) {
      const double hand = SweepingHand(tick);
      const double estimate = estimator.Update(plant.position(), 1, plant.sensed());
      const LoopSample sample = simulation.Step(hand);
      ASSERT_EQ(sample.position, plant.position()) << tick;
      ASSERT_EQ(sample.acceleration, estimate);
      ASSERT_EQ(sample.force, mass * estimate);
      const LoopSample in_counts = counted.Step(hand);
      if (kind == EstimatorKind::kAccelerometer) {
        ASSERT_EQ(in_counts.acceleration, std::round(in_counts.acceleration / 0.5) * 0.5);
      }
      plant.Command(mass * estimate);
      plant.Advance(hand);
    }
  }
}

// The sensor between the events of friction: the same as by small steps of y' = w_a (x'' - y), x'' from the
// velocities that a simulation of a hundredth of the tick shows.
TEST(LoopSimulation, SensesAccelerationThroughFrictionAsSmallStepsDo) {
  LoopParameters loop = TableTwo();
  loop.estimator = EstimatorKind::kAccelerometer;
  loop.accelerometer_bandwidth_hz = 120;
  constexpr double kFriction = 0.4;
  constexpr int kParts = 100;
  FrictionSimulation whole(loop, kFriction);
  LoopParameters fine = loop;
  fine.period_s /= kParts;
  FrictionSimulation parts(fine, kFriction);
  const double rate = 2 * std::numbers::pi * loop.accelerometer_bandwidth_hz;
  const double kept = std::exp(-rate * fine.period_s);
  double sensed = 0;
  double largest = 0;
  for (int tick = 0; tick < 1500; ++tick) {
    const double force = 2 * std::sin(0.05 * tick);
    whole.Command(force);
    parts.Command(force);
    const double from = whole.hand_position();
    const double hand = SweepingHand(tick);
    for (int part = 1; part <= kParts; ++part) {
      const double before = parts.velocity();
      parts.Advance(from + (hand - from) * part / kParts);
      sensed = kept * sensed + (1 - kept) * (parts.velocity() - before) / fine.period_s;
    }
    whole.Advance(hand);
    largest = std::max(largest, std::abs(sensed));
    ASSERT_NEAR(whole.sensed(), parts.sensed(), 1e-6 * (1 + largest)) << tick;
    ASSERT_NEAR(whole.sensed(), sensed, 0.02 * largest + 1e-3) << tick;
  }
  EXPECT_GT(largest, 1);
}

TEST(LoopSimulation, AfterAResetRepeatsItself) {
  for (const double friction : {0.0, 0.3}) {
    LoopSimulation simulation(TableTwo(), 0.1, {.position_quantum = 1e-5, .coulomb_friction = friction});
    simulation.Reset(0.01, 0.2, 0.03);
    const LoopSample first = simulation.Step(0.02);
    const LoopSample second = simulation.Step(0.02);
    EXPECT_EQ(first.position, 0.01);
    EXPECT_EQ(first.velocity, 0.2);
    EXPECT_EQ(first.acceleration, 0);
    EXPECT_NE(second.acceleration, 0);
    simulation.Reset(0.01, 0.2, 0.03);
    simulation.Step(0.02);
    const LoopSample again = simulation.Step(0.02);
    EXPECT_EQ(again.position, second.position);
    EXPECT_EQ(again.acceleration, second.acceleration);
    EXPECT_EQ(again.hand_force, second.hand_force);
  }
}

TEST(LoopSimulation, CountsLikeTheRenderingLoop) {
  const Imperfections counts{.position_quantum = 1.7e-5, .force_quantum = 3e-3, .force_limit = 2.5};
  const int32_t largest = render::LargestForceCounts(counts.force_limit, counts.force_quantum);
  LoopParameters loop = TableTwo();
  loop.delay_s = 1.4e-3;
  LoopSimulation simulation(loop, 0.3, counts);
  HybridSimulation plant(loop);
  AccelerationEstimator estimator(loop.period_s, loop.cutoff_hz);
  int saturated = 0;
  for (int tick = 0; tick < 3000; ++tick) {
    const int64_t position_counts = std::llround(plant.position() / counts.position_quantum);
    const double estimate = estimator.Update(render::PositionOf(position_counts, counts.position_quantum));
    const render::ForceCommand force = render::LimitForce(0.3 * estimate, counts.force_quantum, largest);
    const LoopSample sample = simulation.Step(SweepingHand(tick));
    ASSERT_EQ(sample.acceleration, estimate) << tick;
    ASSERT_EQ(sample.force, force.counts * counts.force_quantum) << tick;
    saturated += force.saturated ? 1 : 0;
    plant.Command(force.counts * counts.force_quantum);
    plant.Advance(SweepingHand(tick));
  }
  EXPECT_GT(saturated, 0);
  EXPECT_LT(saturated, 1000);
}

TEST(LoopSimulation, ForcesAreTheNearestCounts) {
  const double quantum = 0.01;
  LoopSimulation simulation(TableTwo(), 0.2, {.force_quantum = quantum});
  std::set<double> counts;
  for (int tick = 0; tick < 2000; ++tick) {
    const LoopSample sample = simulation.Step(SweepingHand(tick));
    EXPECT_NEAR(sample.force, 0.2 * sample.acceleration, quantum / 2 * (1 + 1e-12));
    EXPECT_EQ(sample.force, std::round(sample.force / quantum) * quantum);
    counts.insert(sample.force);
  }
  EXPECT_GT(counts.size(), 20);
}

TEST(LoopSimulation, ForceIsNeverBeyondItsLimit) {
  for (const double quantum : {0.0, 0.01, 0.03, 1e-300}) {
    LoopSimulation simulation(TableTwo(), 1, {.force_quantum = quantum, .force_limit = 0.3});
    double largest = 0;
    int saturated = 0;
    for (int tick = 0; tick < 2000; ++tick) {
      const LoopSample sample = simulation.Step(SweepingHand(tick));
      largest = std::max(largest, std::abs(sample.force));
      saturated += std::abs(sample.acceleration) > 0.3 + quantum ? 1 : 0;
      ASSERT_LE(std::abs(sample.force), 0.3);
      ASSERT_GE(sample.force * sample.acceleration, 0);
    }
    EXPECT_GT(saturated, 100);
    EXPECT_NEAR(largest, 0.3, 1e-15) << quantum;
  }
}

TEST(LoopSimulation, LargestForceIsAWholeCountAlsoJustBelowTheNext) {
  // The limit is 17 counts less a rounding, and divided by the count it rounds to 17.
  const double quantum = 0.1;
  const double limit = std::nextafter(17 * quantum, 0);
  ASSERT_EQ(std::floor(limit / quantum), 17);
  LoopSimulation simulation(TableTwo(), 1, {.force_quantum = quantum, .force_limit = limit});
  double largest = 0;
  for (int tick = 0; tick < 2000; ++tick) {
    largest = std::max(largest, std::abs(simulation.Step(SweepingHand(tick)).force));
  }
  EXPECT_EQ(largest, 16 * quantum);
}

TEST(LoopSimulation, ForceLimitNeverMetChangesNothing) {
  LoopSimulation free(TableTwo(), 0.2);
  LoopSimulation limited(TableTwo(), 0.2, {.force_limit = 5});
  for (int tick = 0; tick < 2000; ++tick) {
    const double force = free.Step(SweepingHand(tick)).force;
    ASSERT_LT(std::abs(force), 5);
    ASSERT_EQ(limited.Step(SweepingHand(tick)).force, force);
  }
}

TEST(LoopSimulation, ForceActsAfterTheDelay) {
  LoopParameters loop = TableTwo();
  loop.delay_s = 2e-3;
  LoopSimulation simulation(loop, 0.5, {.coulomb_friction = 0.01});
  LoopSimulation without_mass(loop, 0, {.coulomb_friction = 0.01});
  int first_force = -1;
  int first_effect = -1;
  for (int tick = 0; tick < 20; ++tick) {
    const LoopSample sample = simulation.Step(0.01);
    const LoopSample unforced = without_mass.Step(0.01);
    if (first_force < 0 && sample.force != 0) {
      first_force = tick;
    }
    if (first_effect < 0 && sample.position != unforced.position) {
      first_effect = tick;
    }
  }
  EXPECT_EQ(first_force, 1);
  EXPECT_EQ(first_effect, first_force + 3);  // two ticks late, and one until the next sample
}

TEST(LoopSimulation, NamesTheImperfectionThatIsOutOfRange) {
  const auto name = [](const Imperfections& imperfections) {
    const auto error = Validate(imperfections);
    return error ? error->parameter : "";
  };
  EXPECT_EQ(name({}), "");
  EXPECT_EQ(name({.position_quantum = -1e-9}), "position_quantum");
  EXPECT_EQ(name({.force_quantum = std::nan("")}), "force_quantum");
  EXPECT_EQ(name({.coulomb_friction = INFINITY}), "coulomb_friction");
  EXPECT_EQ(name({.force_limit = -1}), "force_limit");
  EXPECT_EQ(name({.force_limit = std::nan("")}), "force_limit");
  EXPECT_EQ(name({.force_limit = 0}), "");
}

}  // namespace
}  // namespace mwidth::model
