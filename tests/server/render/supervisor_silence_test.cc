// A drive that does not answer, through the tick that runs it: what counts is what the drive gets.
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
  EXPECT_EQ(axis.drive.last_written_counts, 0);  // Told twice: by the force and by the switch.
  EXPECT_FALSE(axis.drive.enabled);
  EXPECT_EQ(axis.sample.force_counts, 0);
  EXPECT_EQ(axis.sample.mass, 0);
}

void ExpectFault(const Axis& axis, Fault fault, double value, double limit) {
  EXPECT_EQ(axis.status.state, State::kFault);
  EXPECT_EQ(axis.status.fault.fault, fault);
  EXPECT_EQ(axis.status.fault.value, value);
  EXPECT_EQ(axis.status.fault.limit, limit);
}

TEST(SupervisorSilenceTest, HoldsTheForceForTwoSilentTicksAndTakesItAwayInTheThird) {
  Axis axis;
  axis.RenderSwinging(kMass);
  const int32_t held = axis.drive.acting_counts;
  ASSERT_NE(held, 0);
  axis.drive.answers_reads = false;
  for (int i = 0; i < 2; ++i) {
    axis.Swing();
    EXPECT_EQ(axis.status.state, State::kRendering);
    EXPECT_TRUE(axis.sample.position_stale);
    EXPECT_EQ(axis.drive.acting_counts, held);
  }
  axis.Swing();
  ExpectFault(axis, Fault::kDriveSilent, 3, 2);
  ExpectSafe(axis);
  axis.drive.answers_reads = true;
  axis.RunTicks(100);
  EXPECT_EQ(axis.status.state, State::kFault);
}

TEST(SupervisorSilenceTest, GoesOnAfterASilenceOfTwoTicks) {
  Axis axis;
  axis.RenderSwinging(kMass);
  for (int i = 0; i < 100; ++i) {
    axis.drive.answers_reads = i % 3 == 0;
    axis.Swing();
    ASSERT_EQ(axis.status.state, State::kRendering);
    ASSERT_LT(std::abs(axis.sample.force),
              6);  // 0.3 kg at 16 m/s^2, and no jump where the answers come back.
  }
}

TEST(SupervisorSilenceTest, CountsAForceThatTheDriveDidNotTakeAsSilence) {
  Axis axis;
  axis.RenderSwinging(kMass);
  axis.drive.takes_writes = false;
  axis.Swing();
  axis.Swing();
  EXPECT_EQ(axis.status.state, State::kRendering);
  axis.Swing();
  ExpectFault(axis, Fault::kDriveSilent, 3, 2);
  ExpectSafe(axis);
}

TEST(SupervisorSilenceTest, CountsMissedTicksWithinASilenceAsSilent) {
  Axis axis;
  axis.RenderSwinging(kMass);
  axis.drive.answers_reads = false;
  axis.Swing(4);
  EXPECT_EQ(axis.status.state, State::kRendering);
  axis.Swing(4);
  ExpectFault(axis, Fault::kDriveSilent, 6, 2);
  ExpectSafe(axis);
}

TEST(SupervisorSilenceTest, LatchesSilenceInReadyButNotInIdle) {
  Axis axis;
  axis.drive.answers_reads = false;
  axis.RunTicks(100);
  EXPECT_EQ(axis.status.state, State::kIdle);
  axis.drive.answers_reads = true;
  axis.Start(kMass, 0);
  axis.RunTicks(10);
  axis.StopRendering();
  axis.RunTicks(300);
  ASSERT_EQ(axis.status.state, State::kReady);
  axis.drive.answers_reads = false;
  axis.RunTicks(3);
  ExpectFault(axis, Fault::kDriveSilent, 3, 2);
  ExpectSafe(axis);
  EXPECT_EQ(axis.status.renderings_ended, 1);
}

TEST(SupervisorSilenceTest, FaultsAtOnceWhereAStartFindsTheDriveSilent) {
  Axis axis;
  axis.drive.answers_reads = false;
  axis.RunTicks(10);
  axis.Start(kMass, 0);
  axis.Run();
  ExpectFault(axis, Fault::kDriveSilent, 11, 2);
  ExpectSafe(axis);
}

TEST(SupervisorSilenceTest, CutsTheRampOfAFaultWhenTheDriveFallsSilentInIt) {
  Axis axis;
  axis.RenderSwinging(kMass);
  axis.MoveTo(1.001);
  ASSERT_TRUE(axis.drive.enabled);
  axis.drive.answers_reads = false;
  axis.RunTicks(3);
  ExpectSafe(axis);
  EXPECT_EQ(axis.status.fault.fault, Fault::kPositionLimit);  // The cause stays.
  EXPECT_EQ(axis.status.fault.number, 1);
}

}  // namespace
}  // namespace mwidth::render
