// What the watches see in a rendering, through the tick that runs it, and what they leave alone.
#include "server/render/supervisor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "tests/server/render/axis.h"

namespace mwidth::render {
namespace {

using exchange::Fault;
using exchange::State;

constexpr double kMass = 0.3;

void ExpectSafe(const Axis& axis) {
  EXPECT_EQ(axis.drive.acting_counts, 0);
  EXPECT_EQ(axis.drive.last_written_counts, 0);
  EXPECT_FALSE(axis.drive.enabled);
  EXPECT_EQ(axis.sample.force_counts, 0);
  EXPECT_EQ(axis.sample.mass, 0);
}

void ExpectFault(const Axis& axis, Fault fault, double value, double limit) {
  EXPECT_EQ(axis.status.state, State::kFault);
  EXPECT_EQ(axis.status.fault.fault, fault);
  EXPECT_NEAR(axis.status.fault.value, value, 1e-9 * std::abs(value));
  EXPECT_NEAR(axis.status.fault.limit, limit, 1e-9 * std::abs(limit));
}

// Ticks of swinging until there is a fault, `most` at most.
int SwingUntilFault(Axis& axis, int most) {
  int ticks = 0;
  for (; ticks < most && axis.status.state != State::kFault; ++ticks) {
    axis.Swing();
  }
  return ticks;
}

// The mass fell to zero in a ramp of 50 ms, and never grew.
void ExpectRampDown(Axis& axis) {
  EXPECT_TRUE(axis.drive.enabled);
  double mass = axis.status.mass;
  for (int i = 0; i < 50; ++i) {
    axis.Swing();
    ASSERT_LE(axis.status.mass, mass);
    mass = axis.status.mass;
  }
  ExpectSafe(axis);
}

TEST(SupervisorWatchTest, FaultsWhereTheForceIsAtItsLimitForPartOfEveryPeriod) {
  LoopConfig config = TestConfig();
  config.force_limit = 4;  // Of the 4.7 N that a swing takes: touched in a quarter of the time.
  Axis axis(config);
  axis.RenderSwinging(kMass);
  ASSERT_EQ(axis.status.state, State::kRendering);
  EXPECT_GT(axis.status.saturated_ticks, 0);
  EXPECT_LT(SwingUntilFault(axis, 2000), 500);
  ExpectFault(axis, Fault::kForceSaturation, 0.101, 0.1);
  ExpectRampDown(axis);
}

TEST(SupervisorWatchTest, FlagsAndCountsAShortSaturationAndGoesOn) {
  LoopConfig config = TestConfig();
  config.force_limit = 4.62;  // Touched in a fifteenth of the time.
  Axis axis(config);
  axis.RenderSwinging(kMass);
  uint64_t flagged = axis.status.saturated_ticks;
  for (int i = 0; i < 5000; ++i) {
    flagged += axis.Swing().saturated ? 1 : 0;
    ASSERT_EQ(axis.status.state, State::kRendering);
  }
  EXPECT_GT(flagged, 100);
  EXPECT_EQ(axis.status.saturated_ticks, flagged);
}

TEST(SupervisorWatchTest, CountsTheMissedTicksOfASaturatedForceAsSaturated) {
  LoopConfig config = TestConfig();
  config.force_limit = 4.6;
  config.watch.gap_s = 1;
  config.watch.max_consecutive_overruns = 1000;
  Axis axis(config);
  axis.RenderSwinging(kMass);
  bool faulted = false;
  for (int i = 0; i < 3000 && !faulted; ++i) {
    axis.Swing(axis.sample.saturated ? 5 : 0);
    faulted = axis.status.state == State::kFault;
  }
  EXPECT_EQ(axis.status.fault.fault, Fault::kForceSaturation);
}

TEST(SupervisorWatchTest, LimitsTheChangeOfTheForceAndFaultsWhereThatGoesOn) {
  LoopConfig config = TestConfig();
  config.force_slew_limit = 30;  // 30 counts a tick; the swing takes up to 59.
  Axis axis(config);
  axis.Start(kMass, 0.2);
  uint64_t limited = 0;
  int32_t before = 0;
  for (int i = 0; i < 3000 && axis.status.state != State::kFault; ++i) {
    const exchange::Sample& sample = axis.Swing();
    ASSERT_LE(std::abs(sample.force_counts - before), 30);
    limited += sample.slew_limited ? 1 : 0;
    before = sample.force_counts;
  }
  ExpectFault(axis, Fault::kForceSlew, 0.101, 0.1);
  EXPECT_EQ(axis.status.slew_limited_ticks, limited);
  ExpectRampDown(axis);
}

TEST(SupervisorWatchTest, DoesNotLetTheSlewLimitKeepAForceBeyondTheRampOfAFault) {
  LoopConfig config = TestConfig();
  config.force_slew_limit = 30;
  config.watch.slew_s = 1;
  Axis axis(config);
  axis.RenderSwinging(kMass);
  axis.RunTicks(400);
  ASSERT_EQ(axis.status.state, State::kRendering);
  axis.EmergencyStop();
  axis.Swing();
  ExpectSafe(axis);
}

TEST(SupervisorWatchTest, CutsTheForceInTheTickInWhichTheEncoderJumps) {
  Axis axis;
  axis.RenderSwinging(kMass);
  ASSERT_NE(axis.drive.acting_counts, 0);
  axis.SetPosition(axis.SwingAt(axis.tick + 1) + 0.5);
  axis.Run();
  EXPECT_EQ(axis.status.fault.fault, Fault::kEncoderJump);
  EXPECT_GT(axis.status.fault.value, 400'000);
  EXPECT_EQ(axis.status.fault.limit, 5000);
  ExpectSafe(axis);
}

TEST(SupervisorWatchTest, LatchesAJumpInReadyAndRefusesAStartWithinASecondOfOne) {
  Axis axis;
  axis.Start(kMass, 0);
  axis.RunTicks(10);
  axis.StopRendering();
  axis.RunTicks(300);
  ASSERT_EQ(axis.status.state, State::kReady);
  axis.SetPosition(0.5);
  axis.Run();
  EXPECT_EQ(axis.status.fault.fault, Fault::kEncoderJump);
  ExpectSafe(axis);

  Axis idle;
  idle.RunTicks(10);
  idle.SetPosition(0.5);
  idle.RunTicks(900);
  EXPECT_EQ(idle.status.state, State::kIdle);
  idle.Start(kMass, 0);
  idle.Run();
  EXPECT_EQ(idle.status.fault.fault, Fault::kEncoderJump);
  ExpectSafe(idle);
  idle.ClearFault();
  idle.RunTicks(100);
  idle.Start(kMass, 0);
  idle.RunTicks(10);
  EXPECT_EQ(idle.status.state, State::kRendering);
}

TEST(SupervisorWatchTest, FaultsWhereTheEncoderFreezesInMotion) {
  Axis axis;
  axis.RenderSwinging(kMass);
  ASSERT_GT(std::abs(axis.status.velocity), 0.5);
  axis.SetPosition(axis.sample.position);
  axis.RunTicks(99);
  EXPECT_EQ(axis.status.state, State::kRendering);
  axis.Run();
  EXPECT_EQ(axis.status.fault.fault, Fault::kEncoderFreeze);
  ExpectSafe(axis);
}

TEST(SupervisorWatchTest, LetsAHandHoldStill) {
  Axis axis;
  axis.Start(kMass, 0);
  axis.MoveTo(0.3);
  axis.RunTicks(20'000);
  EXPECT_EQ(axis.status.state, State::kRendering);
}

TEST(SupervisorWatchTest, GoesOnOverTheWrapOfTheDrivesCounter) {
  ScriptedDrive drive;
  drive.info.position_bits = 16;
  auto crossing = std::make_unique<exchange::Crossing>();
  Axis axis;
  Tick through(axis.config, axis.drive, *axis.crossing);
  Tick wrapping(axis.config, drive, *crossing);
  axis.Start(kMass, 0);
  crossing->settings.Post(axis.settings);
  exchange::Sample sample;
  for (uint64_t tick = 1; tick < 2000; ++tick) {
    axis.SetPosition(axis.SwingAt(tick));  // 0.2 m are three turns of 65536 counts.
    drive.position_counts = axis.drive.position_counts & 0xFFFF;
    through.Run(tick, static_cast<int64_t>(tick), 0);
    wrapping.Run(tick, static_cast<int64_t>(tick), 0);
    ASSERT_TRUE(axis.crossing->samples.Pop(axis.sample));
    ASSERT_TRUE(crossing->samples.Pop(sample));
    ASSERT_EQ(sample.position_counts, axis.sample.position_counts);
    ASSERT_EQ(sample.force_counts, axis.sample.force_counts);
    ASSERT_EQ(sample.state, State::kRendering);
  }
}

TEST(SupervisorWatchTest, FaultsWhereTooManyTicksInARowMissADeadline) {
  Axis axis;
  axis.RenderSwinging(kMass);
  for (int i = 0; i < 10; ++i) {
    axis.Swing(1);
    ASSERT_EQ(axis.status.state, State::kRendering);
  }
  axis.Swing();
  for (int i = 0; i < 10; ++i) {
    axis.Swing(2);
    ASSERT_EQ(axis.status.state, State::kRendering);
  }
  axis.Swing(1);
  ExpectFault(axis, Fault::kRepeatedOverrun, 11, 10);
  ExpectSafe(axis);
}

TEST(SupervisorWatchTest, FaultsWhereTheDriveAnswersOnlyEveryOtherTick) {
  Axis axis;
  axis.RenderSwinging(kMass);
  int ticks = 0;
  for (; ticks < 2000 && axis.status.state == State::kRendering; ++ticks) {
    axis.drive.answers_reads = ticks % 2 == 0;
    axis.Swing();
  }
  EXPECT_LT(ticks, 410);
  ExpectFault(axis, Fault::kPositionGaps, 0.201, 0.2);
  axis.drive.answers_reads = true;
  ExpectRampDown(axis);
}

TEST(SupervisorWatchTest, FaultsWhereTheDriveTakesOnlyEveryOtherForceOrEveryOtherDeadlineIsMissed) {
  Axis refusing;
  refusing.RenderSwinging(kMass);
  for (int i = 0; i < 500; ++i) {
    refusing.drive.takes_writes = i % 2 == 0;
    refusing.Swing();
  }
  EXPECT_EQ(refusing.status.fault.fault, Fault::kPositionGaps);

  Axis missing;
  missing.RenderSwinging(kMass);
  for (int i = 0; i < 500; ++i) {
    missing.Swing(i % 2 == 0 ? 1 : 0);
  }
  EXPECT_EQ(missing.status.fault.fault, Fault::kPositionGaps);
}

TEST(SupervisorWatchTest, BearsAGapNowAndThen) {
  Axis axis;
  axis.RenderSwinging(kMass);
  for (int i = 0; i < 5000; ++i) {
    axis.drive.answers_reads = i % 10 != 0;
    axis.Swing(i % 100 == 5 ? 5 : 0);
    ASSERT_EQ(axis.status.state, State::kRendering);
  }
}

TEST(SupervisorWatchTest, FaultsWhereTheForceComesTooLateAgainAndAgain) {
  LoopConfig config = TestConfig();
  config.watch.delay_limit_s = 250e-6;
  Axis axis(config);
  axis.RenderSwinging(kMass);
  for (int i = 0; i < 3000; ++i) {
    axis.tick_under_test().ReportLoopDelay(i % 20 == 0 ? 900'000 : 250'000);
    axis.Swing();
    ASSERT_EQ(axis.status.state, State::kRendering);
  }
  int ticks = 0;
  for (; ticks < 1000 && axis.status.state == State::kRendering; ++ticks) {
    axis.tick_under_test().ReportLoopDelay(ticks % 3 == 0 ? 251'000 : 20'000);
    axis.Swing();
  }
  EXPECT_LT(ticks, 310);
  ExpectFault(axis, Fault::kLoopDelay, 251e-6, 250e-6);
  ExpectRampDown(axis);
}

TEST(SupervisorWatchTest, ForgetsWhatWasBeforeAStart) {
  LoopConfig config = TestConfig();
  config.watch.delay_limit_s = 250e-6;
  Axis axis(config);
  for (int i = 0; i < 1000; ++i) {
    axis.drive.answers_reads = i % 2 == 0;
    axis.tick_under_test().ReportLoopDelay(900'000);
    axis.Run();
  }
  axis.drive.answers_reads = true;
  axis.tick_under_test().ReportLoopDelay(20'000);
  axis.Start(kMass, 0);
  axis.RunTicks(1000);
  EXPECT_EQ(axis.status.state, State::kRendering);
}

}  // namespace
}  // namespace mwidth::render
