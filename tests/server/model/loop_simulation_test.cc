// Each imperfection alone, against what it must do by theory; and without any, the model itself.
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

namespace mwidth::model {
namespace {

LoopParameters PaperLoop() {
  return {.device_mass = 0.07,
          .device_damping = 0.005,
          .hand_damping = 5,
          .hand_stiffness = 700,
          .period_s = 1e-3,
          .cutoff_hz = 10};
}

/// A hand that sweeps 20 mm to and fro, 1 Hz rising to 3 Hz.
double SweepingHand(int tick) {
  const double t = tick * 1e-3;
  return 0.02 * std::sin(2 * std::numbers::pi * t * (1 + 0.5 * t));
}

TEST(LoopSimulation, WithoutImperfectionsIsTheHybridLoopBitForBit) {
  std::mt19937_64 random(2012);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int i = 0; i < 50; ++i) {
    LoopParameters loop = PaperLoop();
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

TEST(LoopSimulation, AfterAResetRepeatsItself) {
  for (const double friction : {0.0, 0.3}) {
    LoopSimulation simulation(PaperLoop(), 0.1, {.position_quantum = 1e-5, .coulomb_friction = friction});
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

TEST(LoopSimulation, EncoderMovesTheDeviceNoFurtherThanItsGainAllows) {
  const double quantum = 20e-6;
  for (const double mass_ratio : {-1.2, -0.5, 3.0, 25.0}) {
    const double mass = mass_ratio * 0.07;
    const double bound = quantum / 2 * LargestGainFromReading(PaperLoop(), mass);
    LoopSimulation exact(PaperLoop(), mass);
    LoopSimulation counted(PaperLoop(), mass, {.position_quantum = quantum});
    double apart = 0;
    for (int tick = 0; tick < 5000; ++tick) {
      const double hand = SweepingHand(tick);
      apart = std::max(apart, std::abs(exact.Step(hand).position - counted.Step(hand).position));
    }
    EXPECT_LE(apart, bound) << mass_ratio;
    EXPECT_GT(apart, bound / 1000) << mass_ratio;
  }
}

TEST(LoopSimulation, EncoderKeepsABoundedLimitCycleAliveUnderAHandAtRest) {
  // Close to its edge the ideal loop rings down; one that reads counts is kept ringing by their edges.
  const double mass = 0.98 * ComputeMWidth(PaperLoop()).upper.mass;
  const double quantum = 20e-6;
  const double bound = quantum / 2 * LargestGainFromReading(PaperLoop(), mass);
  const Imperfections encoder{.position_quantum = quantum};
  double exact_swing = 0;
  double counted_swing = 0;
  LoopSimulation exact(PaperLoop(), mass);
  LoopSimulation counted(PaperLoop(), mass, encoder);
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

TEST(LoopSimulation, CountsLikeTheRenderingLoop) {
  const Imperfections counts{.position_quantum = 1.7e-5, .force_quantum = 3e-3, .force_limit = 2.5};
  const int32_t largest = render::LargestForceCounts(counts.force_limit, counts.force_quantum);
  LoopParameters loop = PaperLoop();
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
  LoopSimulation simulation(PaperLoop(), 0.2, {.force_quantum = quantum});
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
    LoopSimulation simulation(PaperLoop(), 1, {.force_quantum = quantum, .force_limit = 0.3});
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

TEST(LoopSimulation, ForceLimitNeverMetChangesNothing) {
  LoopSimulation free(PaperLoop(), 0.2);
  LoopSimulation limited(PaperLoop(), 0.2, {.force_limit = 5});
  for (int tick = 0; tick < 2000; ++tick) {
    const double force = free.Step(SweepingHand(tick)).force;
    ASSERT_LT(std::abs(force), 5);
    ASSERT_EQ(limited.Step(SweepingHand(tick)).force, force);
  }
}

TEST(LoopSimulation, SaturationHoldsAnUnstableLoopAtTheAmplitudeOfTheDescribingFunction) {
  // A sine of amplitude A through a limit F keeps 2/pi (asin(F/A) + F/A sqrt(1 - F^2/A^2)) of its size; the
  // loop swings where that takes the mass back to its edge (Slotine and Li, Applied Nonlinear Control, 1991).
  // At the lower edge: the upper one's 262 Hz would lock onto four ticks.
  const Edge edge = ComputeMWidth(PaperLoop()).lower;
  const double mass = 1.25 * edge.mass;
  const double limit = 2;
  LoopSimulation simulation(PaperLoop(), mass, {.force_limit = limit});
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

TEST(LoopSimulation, FrictionHoldsTheDeviceThatAWeakHandPulls) {
  LoopSimulation simulation(PaperLoop(), 0.1, {.coulomb_friction = 1.4});
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

TEST(LoopSimulation, FrictionBringsALoopBeyondItsEdgeToRestFromASmallPush) {
  const double mass = 1.01 * ComputeMWidth(PaperLoop()).upper.mass;
  LoopSimulation ideal(PaperLoop(), mass);
  LoopSimulation rough(PaperLoop(), mass, {.coulomb_friction = 0.1});
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

TEST(LoopSimulation, ForceActsAfterTheDelay) {
  LoopParameters loop = PaperLoop();
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
