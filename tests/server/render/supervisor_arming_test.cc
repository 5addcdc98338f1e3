// Drives that need time to be enabled, and drives that report trouble.
#include <gtest/gtest.h>

#include "tests/server/render/axis.h"

namespace mwidth::render {
namespace {

using exchange::Fault;
using exchange::State;

constexpr double kMass = 0.5;

TEST(SupervisorArmingTest, WaitsInIdleForADriveThatIsOnItsWay) {
  Axis axis;
  axis.drive.ticks_to_enable = 10;
  axis.Start(kMass, 0);
  for (int i = 0; i < 10; ++i) {
    axis.Run();
    EXPECT_EQ(axis.status.state, State::kIdle);
    EXPECT_EQ(axis.drive.writes, 0);
  }
  axis.Run();
  EXPECT_EQ(axis.status.state, State::kRendering);
  EXPECT_EQ(axis.status.render_epoch, axis.settings.render_epoch);
  EXPECT_EQ(axis.drive.disables, 0);
}

TEST(SupervisorArmingTest, LosesPatience) {
  Axis axis;
  axis.drive.ticks_to_enable = 100'000;
  axis.Start(kMass, 0);
  axis.Run();
  axis.RunTicks(800);
  EXPECT_EQ(axis.status.state, State::kIdle);
  axis.Run();
  EXPECT_EQ(axis.status.fault.fault, Fault::kDriveRefused);
  EXPECT_FALSE(axis.drive.arming);
  const int enables = axis.drive.enables;
  axis.RunTicks(10);
  EXPECT_EQ(axis.drive.enables, enables);
}

TEST(SupervisorArmingTest, HasPatienceAnewForAnotherStart) {
  Axis axis;
  axis.drive.ticks_to_enable = 1200;
  axis.Start(kMass, 0);
  axis.RunTicks(700);
  axis.StopRendering();
  axis.Run();
  axis.Start(kMass, 0);
  axis.RunTicks(505);
  EXPECT_EQ(axis.status.state, State::kRendering);
}

TEST(SupervisorArmingTest, TakesAStartBackThatIsNoLongerWanted) {
  for (const bool lease_is_lost : {false, true}) {
    Axis axis;
    axis.drive.ticks_to_enable = 10;
    axis.Start(kMass, 0);
    axis.RunTicks(5);
    if (lease_is_lost) {
      axis.settings.lease_deadline_ns = axis.now_ns;
      axis.Post();
    } else {
      axis.StopRendering();
    }
    axis.Run();
    EXPECT_EQ(axis.drive.disables, 1);
    axis.drive.ticks_to_enable = 0;
    axis.settings.rendering = true;
    axis.settings.lease_deadline_ns = INT64_MAX;
    axis.Post();  // The same start does not come back to life.
    axis.RunTicks(20);
    EXPECT_EQ(axis.status.state, State::kIdle);
    EXPECT_EQ(axis.drive.enables, 5);
  }
}

TEST(SupervisorArmingTest, ObeysAnEmergencyStopOnTheWay) {
  Axis axis;
  axis.drive.ticks_to_enable = 10;
  axis.Start(kMass, 0);
  axis.RunTicks(5);
  axis.EmergencyStop();
  axis.RunTicks(20);
  EXPECT_EQ(axis.status.fault.fault, Fault::kEmergencyStop);
  EXPECT_EQ(axis.drive.enables, 5);
  EXPECT_FALSE(axis.drive.arming);
  axis.ClearFault();
  axis.RunTicks(20);
  EXPECT_EQ(axis.status.state, State::kIdle);
  EXPECT_EQ(axis.drive.enables, 5);
}

TEST(SupervisorArmingTest, DisablesADriveOnTheWayWhenTheLoopEnds) {
  Axis axis;
  axis.drive.ticks_to_enable = 10;
  axis.Start(kMass, 0);
  axis.RunTicks(5);
  axis.tick_under_test().BeginStop();
  axis.Run();
  EXPECT_TRUE(axis.tick_under_test().AtRest());
  EXPECT_FALSE(axis.drive.arming);
}

TEST(SupervisorArmingTest, CutsTheForceWhereTheDriveReportsTrouble) {
  const std::pair<device::DriveTrouble, Fault> troubles[] = {
      {device::DriveTrouble::kError, Fault::kDriveError},
      {device::DriveTrouble::kForeignTraffic, Fault::kForeignTraffic}};
  for (const auto& [trouble, fault] : troubles) {
    for (const bool answers : {true, false}) {
      Axis axis;
      axis.RenderSwinging(kMass);
      ASSERT_NE(axis.drive.acting_counts, 0);
      axis.drive.trouble = trouble;
      axis.drive.trouble_code = 0xFF10;
      axis.drive.answers_reads = answers;
      axis.Run();
      EXPECT_EQ(axis.status.fault.fault, fault);
      EXPECT_EQ(axis.status.fault.value, 0xFF10);
      EXPECT_EQ(axis.drive.acting_counts, 0);
      EXPECT_FALSE(axis.drive.enabled);
    }
  }
}

TEST(SupervisorArmingTest, TroubleOfADisabledDriveIsNoFault) {
  Axis axis;
  axis.drive.trouble = device::DriveTrouble::kError;
  axis.RunTicks(5);
  EXPECT_EQ(axis.status.state, State::kIdle);
}

}  // namespace
}  // namespace mwidth::render
