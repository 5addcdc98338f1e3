// The states without faults, through the tick that runs it: what counts is what the drive gets.
#include "server/render/supervisor.h"

#include <gtest/gtest.h>

#include <cstdint>

#include "tests/server/render/axis.h"

namespace mwidth::render {
namespace {

using exchange::State;

constexpr double kMass = 0.3;

TEST(SupervisorTest, WaitsInIdleWithTheDriveDisabled) {
  Axis axis;
  axis.RunTicks(50);
  EXPECT_EQ(axis.status.state, State::kIdle);
  EXPECT_EQ(axis.drive.enables, 0);
}

TEST(SupervisorTest, EnablesTheDriveAndRampsTheMassFromZeroOnAStart) {
  Axis axis;
  axis.Start(kMass, 0.1);
  axis.Run();
  EXPECT_EQ(axis.status.state, State::kRendering);
  EXPECT_EQ(axis.status.render_epoch, 1);
  EXPECT_EQ(axis.drive.enables, 1);
  EXPECT_NEAR(axis.status.mass, kMass / 100, 1e-15);
  axis.RunTicks(49);
  EXPECT_NEAR(axis.status.mass, kMass / 2, 1e-15);
  axis.RunTicks(50);
  EXPECT_EQ(axis.status.mass, kMass);
  axis.RunTicks(1000);
  EXPECT_EQ(axis.status.mass, kMass);
}

TEST(SupervisorTest, RampsToANewMassWhileRendering) {
  Axis axis;
  axis.RenderSwinging(kMass);
  axis.settings.mass = -0.1;
  axis.settings.ramp_s = 0.1;
  axis.Post();
  axis.RunTicks(50);
  EXPECT_NEAR(axis.status.mass, 0.1, 1e-15);
  EXPECT_EQ(axis.status.target_mass, -0.1);
  axis.Post();  // A renewed lease posts the same mass again and does not begin the ramp anew.
  axis.RunTicks(50);
  EXPECT_EQ(axis.status.mass, -0.1);
}

TEST(SupervisorTest, RampsToZeroOnAStopAndStaysReadyWithTheDriveEnabled) {
  Axis axis;
  axis.RenderSwinging(kMass);
  axis.StopRendering();
  axis.Swing();
  EXPECT_EQ(axis.status.state, State::kRendering);
  EXPECT_NEAR(axis.status.mass, kMass * 199 / 200, 1e-15);
  EXPECT_EQ(axis.status.renderings_ended, 0);
  axis.RunTicks(199);
  EXPECT_EQ(axis.status.state, State::kReady);
  EXPECT_EQ(axis.status.mass, 0);
  EXPECT_EQ(axis.status.renderings_ended, 1);
  EXPECT_TRUE(axis.drive.enabled);
  EXPECT_EQ(axis.drive.acting_counts, 0);
}

TEST(SupervisorTest, BeginsAgainFromReadyOnlyWithANewEpoch) {
  Axis axis;
  axis.RenderSwinging(kMass);
  axis.StopRendering();
  axis.RunTicks(300);
  axis.settings.rendering = true;
  axis.Post();
  axis.RunTicks(300);
  EXPECT_EQ(axis.status.state, State::kReady);
  axis.Start(kMass, 0.1);
  axis.Run();
  EXPECT_EQ(axis.status.state, State::kRendering);
  EXPECT_EQ(axis.status.render_epoch, 2);
  EXPECT_EQ(axis.drive.enables, 1);
}

TEST(SupervisorTest, EndsAStopThatIsTakenBackAndBeginsAgainOnlyAfterAStartDuringIt) {
  Axis axis;
  axis.RenderSwinging(kMass);
  axis.StopRendering();
  axis.RunTicks(100);
  axis.settings.rendering = true;
  axis.Post();
  axis.RunTicks(100);
  EXPECT_EQ(axis.status.state, State::kReady);

  axis.Start(kMass, 0);
  axis.RunTicks(10);
  axis.StopRendering();
  axis.RunTicks(100);
  axis.Start(kMass, 0);
  axis.RunTicks(100);
  EXPECT_EQ(axis.status.state, State::kReady);
  axis.Run();
  EXPECT_EQ(axis.status.state, State::kRendering);
  EXPECT_EQ(axis.status.render_epoch, 3);
}

TEST(SupervisorTest, DoesNotObeyAStartFromBeforeTheLoop) {
  for (const bool taken_before : {false, true}) {
    Axis axis;
    axis.Start(kMass, 0);
    if (taken_before) {
      axis.RunTicks(10);
      axis.tick_under_test().Close();
    }
    const int enables = axis.drive.enables;
    Tick again(axis.config, axis.drive, *axis.crossing);  // As after a crash of the loop.
    again.Run(1, 1, 0);
    axis.Post();  // A renewed lease posts the old epoch again.
    again.Run(2, 2, 0);
    EXPECT_EQ(axis.drive.enables, enables);
    ++axis.settings.render_epoch;
    axis.Post();
    again.Run(3, 3, 0);
    EXPECT_EQ(axis.drive.enables, enables + 1);
  }
}

TEST(SupervisorTest, ForfeitsAStartWhoseLeaseHasRunOut) {
  Axis axis;
  axis.Start(kMass, 0);
  axis.settings.lease_deadline_ns = axis.now_ns + axis.period_ns;
  axis.Post();
  axis.Run();  // At the deadline itself.
  EXPECT_EQ(axis.status.state, State::kIdle);
  axis.settings.lease_deadline_ns = INT64_MAX;
  axis.Post();
  axis.RunTicks(10);
  EXPECT_EQ(axis.status.state, State::kIdle);
  EXPECT_EQ(axis.drive.enables, 0);
}

TEST(SupervisorTest, RampsToZeroWithin500MsOfTheLeaseDeadlineAlsoWhereTicksAreMissed) {
  for (const uint64_t missed : {uint64_t{0}, uint64_t{5}}) {
    LoopConfig config = TestConfig();
    config.period_s = 0.01;
    config.watch.gap_s = 1;
    Axis axis(config);
    axis.RenderSwinging(kMass);
    axis.settings.lease_deadline_ns = axis.now_ns + 1;
    axis.Post();
    const int64_t deadline_ns = axis.settings.lease_deadline_ns;
    axis.Swing(missed);
    EXPECT_EQ(axis.status.state, State::kRendering);
    EXPECT_LT(axis.status.mass, kMass);
    while (axis.status.state == State::kRendering && axis.now_ns < deadline_ns + 1'000'000'000) {
      axis.Swing(missed);
    }
    EXPECT_EQ(axis.status.state, State::kReady);
    EXPECT_EQ(axis.drive.acting_counts, 0);
    EXPECT_LE(axis.now_ns, deadline_ns + 500'000'000);
    EXPECT_EQ(axis.status.renderings_ended, 1);
  }
}

TEST(SupervisorTest, DoesNotBeginAgainWhenALostLeaseIsRenewed) {
  Axis axis;
  axis.RenderSwinging(kMass);
  axis.settings.lease_deadline_ns = axis.now_ns;
  ++axis.settings.render_epoch;  // A start that arrives with a lease that is gone.
  axis.Post();
  axis.RunTicks(10);
  axis.settings.lease_deadline_ns = INT64_MAX;
  axis.Post();
  axis.RunTicks(500);
  EXPECT_EQ(axis.status.state, State::kReady);
  EXPECT_EQ(axis.status.render_epoch, 1);
}

TEST(SupervisorTest, RampsDownAndBeginsNothingMoreWhenTheLoopStops) {
  Axis axis;
  axis.RenderSwinging(kMass);
  axis.tick_under_test().BeginStop();
  EXPECT_FALSE(axis.tick_under_test().AtRest());
  axis.RunTicks(199);
  EXPECT_FALSE(axis.tick_under_test().AtRest());
  axis.Run();
  EXPECT_TRUE(axis.tick_under_test().AtRest());
  axis.Start(kMass, 0);
  axis.RunTicks(100);
  EXPECT_EQ(axis.status.state, State::kReady);
}

}  // namespace
}  // namespace mwidth::render
