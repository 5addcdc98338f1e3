#include "server/render/tick.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "tests/server/render/axis.h"

namespace mwidth::render {
namespace {

using exchange::Sample;
using exchange::State;

bool SameBits(double a, double b) { return std::bit_cast<uint64_t>(a) == std::bit_cast<uint64_t>(b); }

// Eqs. 3 to 5 as sums over all positions so far, in another precision than the tick's.
long double ForceBySum(const std::vector<long double>& x, long double mass, const LoopConfig& config) {
  const long double period = config.period_s;
  const long double a = std::exp(-2 * std::numbers::pi_v<long double> * config.cutoff_hz * period);
  const auto at = [&x](int64_t n) { return x[static_cast<std::size_t>(std::max<int64_t>(n, 0))]; };
  long double filtered = 0;
  long double weight = 1 - a;
  for (auto n = static_cast<int64_t>(x.size()) - 1; n >= 0; --n) {
    filtered += weight * (at(n) - 2 * at(n - 1) + at(n - 2)) / (period * period);
    weight *= a;
  }
  return mass * filtered;
}

TEST(TickTest, CommandsTheMassTimesTheEstimatedAcceleration) {
  for (const double mass : {0.35, -0.08}) {
    Axis axis;
    axis.Start(mass, 0);
    std::vector<long double> positions;
    for (int i = 0; i < 800; ++i) {
      const Sample& sample = axis.Swing();
      positions.push_back(axis.drive.position_counts *
                          static_cast<long double>(axis.drive.info.position_quantum));
      const auto expected = static_cast<double>(ForceBySum(positions, mass, axis.config));
      ASSERT_NEAR(axis.drive.acting_counts * axis.drive.info.force_quantum, expected,
                  0.5001 * axis.drive.info.force_quantum)
          << "tick " << sample.tick;
      ASSERT_FALSE(sample.saturated);
    }
    EXPECT_NEAR(std::abs(axis.sample.mass), std::abs(mass), 0);
  }
}

TEST(TickTest, RecordsTheForceThatTheDriveWasGiven) {
  Axis axis;
  axis.RenderSwinging(0.3);
  for (int i = 0; i < 200; ++i) {
    const Sample& sample = axis.Swing();
    ASSERT_EQ(sample.force_counts, axis.drive.acting_counts);
    ASSERT_TRUE(SameBits(sample.force, sample.force_counts * axis.drive.info.force_quantum));
    ASSERT_EQ(axis.status.force, sample.force);
  }
}

TEST(TickTest, LeavesSamplesFromWhichEverythingFollowsBitForBit) {
  Axis axis;
  axis.Start(0.3, 0.1);
  model::AccelerationEstimator estimator(axis.config.period_s, axis.config.cutoff_hz);
  const int32_t largest = LargestForceCounts(axis.config.force_limit, axis.drive.info.force_quantum);
  uint64_t last_answer = 0;
  for (int i = 0; i < 600; ++i) {
    axis.drive.answers_reads = i % 50 != 7;
    const Sample sample = axis.Swing(i % 40 == 3 ? 2 : 0);
    if (!sample.position_stale) {
      estimator.Update(static_cast<double>(sample.position_counts) * axis.drive.info.position_quantum,
                       sample.tick - last_answer);
      last_answer = sample.tick;
    }
    ASSERT_TRUE(SameBits(sample.position, estimator.position()));
    ASSERT_TRUE(SameBits(sample.velocity, estimator.velocity()));
    ASSERT_TRUE(SameBits(sample.acceleration, estimator.acceleration()));
    const ForceCommand force =
        LimitForce(sample.mass * sample.acceleration, axis.drive.info.force_quantum, largest);
    ASSERT_EQ(sample.force_counts, force.counts);
    ASSERT_EQ(sample.saturated, force.saturated);
    ASSERT_EQ(sample.state, State::kRendering);
  }
}

TEST(TickTest, LeavesSamplesFromAnyOfWhichTheNextFollowBitForBit) {
  constexpr std::array kKinds{model::EstimatorKind::kKalman, model::EstimatorKind::kButterworth,
                              model::EstimatorKind::kLateFilteredDifference,
                              model::EstimatorKind::kFilteredDifference};
  Axis axis;
  axis.drive.answers_reads = false;
  Sample last = axis.Run();
  EXPECT_EQ(last.answered_tick, 0);
  for (int i = 0; i < 2000; ++i) {
    if (i % 400 == 100) {
      axis.settings.filter = {
          .estimator = static_cast<uint8_t>(kKinds[static_cast<std::size_t>(i / 400) % 4]), .cutoff_hz = 20};
      axis.Post();
    }
    axis.drive.answers_reads = i % 50 >= 3;
    const Sample sample = axis.Swing(i % 40 == 3 ? 2 : 0);
    model::AccelerationEstimator estimator(axis.config.period_s, last.filter.cutoff_hz,
                                           static_cast<model::EstimatorKind>(last.filter.estimator));
    estimator.Restore({.position = last.position,
                       .velocity = last.velocity,
                       .acceleration = last.acceleration,
                       .low_pass = last.filter_memory,
                       .primed = last.answered_tick != 0});
    if (sample.filter != last.filter) {
      estimator = estimator.ChangedTo(static_cast<model::EstimatorKind>(sample.filter.estimator),
                                      sample.filter.cutoff_hz);
    }
    if (!sample.position_stale) {
      estimator.Update(sample.position, sample.tick - last.answered_tick);
    }
    ASSERT_TRUE(SameBits(sample.velocity, estimator.velocity())) << i;
    ASSERT_TRUE(SameBits(sample.acceleration, estimator.acceleration())) << i;
    ASSERT_EQ(sample.filter_memory, estimator.Memory().low_pass) << i;
    ASSERT_EQ(sample.answered_tick, sample.position_stale ? last.answered_tick : sample.tick);
    last = sample;
  }
  EXPECT_EQ(last.filter, axis.settings.filter);
}

TEST(TickTest, TellsWhetherTheDriveTookTheForce) {
  Axis axis;
  EXPECT_FALSE(axis.Swing().force_taken);
  axis.RenderSwinging(0.3);
  EXPECT_TRUE(axis.sample.force_taken);
  axis.drive.takes_writes = false;
  EXPECT_FALSE(axis.Swing().force_taken);
  axis.drive.takes_writes = true;
  EXPECT_TRUE(axis.Swing().force_taken);
  EXPECT_EQ(axis.sample.force_counts, axis.drive.acting_counts);
}

TEST(TickTest, ClampsTheForceAndSaysSo) {
  LoopConfig config = TestConfig();
  config.force_limit =
      1.0005;  // Not a whole number of counts: the force must stay below, not round up to 1.001.
  config.watch.saturation_s = 1;
  Axis axis(config);
  axis.RenderSwinging(0.5);
  bool saturated = false;
  for (int i = 0; i < 500; ++i) {
    const Sample& sample = axis.Swing();
    saturated = saturated || sample.saturated;
    ASSERT_LE(std::abs(sample.force_counts), 1000);
    ASSERT_EQ(sample.saturated, std::abs(sample.mass * sample.acceleration) >= 1.0005);
  }
  EXPECT_TRUE(saturated);
}

TEST(TickTest, GivesNoForceOutsideRendering) {
  Axis axis;
  for (int i = 0; i < 300; ++i) {
    ASSERT_EQ(axis.Swing().force_counts, 0);
    ASSERT_EQ(axis.sample.state, State::kIdle);
  }
  EXPECT_EQ(axis.drive.writes, 0);
  axis.RenderSwinging(0.3);
  axis.StopRendering();
  for (int i = 0; i < 200; ++i) {
    axis.Swing();
  }
  ASSERT_EQ(axis.sample.state, State::kReady);
  for (int i = 0; i < 300; ++i) {
    ASSERT_EQ(axis.Swing().force_counts, 0);
    ASSERT_EQ(axis.drive.acting_counts, 0);
  }
  EXPECT_TRUE(axis.drive.enabled);
  EXPECT_EQ(axis.drive.writes_while_disabled, 0);
}

TEST(TickTest, SeesNoStepWhereTheArmRestsAtTheFirstTick) {
  Axis axis;
  axis.SetPosition(0.7);
  axis.Start(0.5, 0);
  for (int i = 0; i < 10; ++i) {
    ASSERT_EQ(axis.Run().acceleration, 0);
    ASSERT_EQ(axis.drive.acting_counts, 0);
  }
}

TEST(TickTest, BridgesMissedTicksWithoutAJumpOfTheForce) {
  Axis through;
  Axis skipping;
  through.RenderSwinging(0.3);
  skipping.RenderSwinging(0.3);
  for (int i = 0; i < 6; ++i) {
    through.Swing();
  }
  skipping.Swing(5);
  ASSERT_EQ(skipping.tick, through.tick);
  EXPECT_EQ(skipping.sample.missed_ticks, 5);
  EXPECT_EQ(skipping.status.missed_ticks, 5);
  EXPECT_EQ(skipping.sample.state, State::kRendering);
  // A held position would put six times the velocity into one sample: thousands of m/s^2, hundreds after the
  // filter. The line between the neighbours gives the same change of velocity, 5 ticks early: it decays by a
  // quarter more.
  EXPECT_NEAR(skipping.sample.acceleration, through.sample.acceleration, 2);
  through.Swing();
  skipping.Swing();
  EXPECT_NEAR(skipping.sample.acceleration, through.sample.acceleration, 2);
}

TEST(TickTest, NumbersTheSamplesAndAnswersTheSettings) {
  Axis axis;
  axis.Start(0.2, 0.1);
  axis.Run();
  EXPECT_EQ(axis.status.settings_sequence, axis.settings.sequence);
  EXPECT_EQ(axis.sample.tick, 1);
  EXPECT_EQ(axis.sample.monotonic_ns, axis.now_ns);
  EXPECT_EQ(axis.status.target_mass, 0.2);
  axis.Run(3);
  EXPECT_EQ(axis.sample.tick, 5);
  EXPECT_EQ(axis.sample.missed_ticks, 3);
  EXPECT_EQ(axis.status.tick, 5);
}

TEST(TickTest, CountsWhatTheRingCannotHold) {
  Axis axis;
  Tick& tick = axis.tick_under_test();
  for (uint64_t k = 1; k <= exchange::kSampleRingCapacity + 3; ++k) {
    tick.Run(k, static_cast<int64_t>(k), 0);
  }
  EXPECT_EQ(axis.crossing->samples.dropped(), 3);
}

TEST(TickTest, PostsThatTheDriveIsDisabledWhenItCloses) {
  Axis axis;
  axis.RenderSwinging(0.3);
  axis.tick_under_test().Close();
  ASSERT_TRUE(axis.crossing->status.Take(axis.status));
  EXPECT_EQ(axis.status.state, State::kIdle);
  EXPECT_EQ(axis.status.force, 0);
  EXPECT_EQ(axis.status.mass, 0);
  EXPECT_EQ(axis.status.renderings_ended, 1);
  EXPECT_FALSE(axis.drive.enabled);
}

}  // namespace
}  // namespace mwidth::render
