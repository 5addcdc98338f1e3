// The faults of the state machine, through the tick that runs it: what counts is what the drive gets.
#include "server/render/supervisor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>

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

TEST(SupervisorFaultTest, TakesTheForceAwayInTheTickOfAnEmergencyStopFromAnyState) {
  const std::function<void(Axis&)> states[] = {
      [](Axis& axis) { axis.Run(); },
      [](Axis& axis) { axis.RenderSwinging(kMass); },
      [](Axis& axis) {
        axis.RenderSwinging(kMass);
        axis.StopRendering();
        axis.RunTicks(300);
      },
      [](Axis& axis) {
        axis.RenderSwinging(kMass);
        axis.StopRendering();
        axis.Swing();
      },
      [](Axis& axis) {  // Within the ramp of another fault.
        axis.RenderSwinging(kMass);
        axis.MoveTo(1.001);
      },
  };
  for (const auto& bring_to_state : states) {
    Axis axis;
    bring_to_state(axis);
    axis.EmergencyStop();
    axis.Run();
    ExpectSafe(axis);
    ExpectFault(axis, Fault::kEmergencyStop, 1, 0);
    axis.Start(kMass, 0);
    axis.RunTicks(100);
    ExpectSafe(axis);
    EXPECT_EQ(axis.status.state, State::kFault);
  }
}

TEST(SupervisorFaultTest, NumbersAnEmergencyStopAboveTheFaultBeforeSoThatClearingThatOneDoesNotClearIt) {
  Axis axis;
  axis.RenderSwinging(kMass);
  axis.MoveTo(1.001);
  const uint64_t position_fault = axis.status.fault.number;
  axis.EmergencyStop();
  axis.RunTicks(100);
  axis.settings.cleared_fault_number = position_fault;
  axis.Post();
  axis.RunTicks(100);
  ExpectFault(axis, Fault::kEmergencyStop, 1, 0);
  EXPECT_EQ(axis.status.fault.number, position_fault + 1);
}

TEST(SupervisorFaultTest, ObeysAnEmergencyStopFromBeforeTheLoop) {
  Axis axis;
  axis.EmergencyStop();
  Tick again(axis.config, axis.drive, *axis.crossing);
  again.Run(1, 1, 0);
  axis.crossing->status.Take(axis.status);
  ExpectFault(axis, Fault::kEmergencyStop, 1, 0);
}

TEST(SupervisorFaultTest, LatchesAFaultUntilItIsClearedAndThenWaitsInIdle) {
  Axis axis;
  axis.RenderSwinging(kMass);
  axis.EmergencyStop();
  axis.RunTicks(5000);
  EXPECT_EQ(axis.status.state, State::kFault);
  EXPECT_EQ(axis.status.fault.number, 1);
  EXPECT_EQ(axis.status.renderings_ended, 1);
  axis.Start(kMass, 0);  // Forfeited: a start in FAULT must not wait for the clearing.
  axis.RunTicks(10);
  axis.ClearFault();
  axis.RunTicks(100);
  EXPECT_EQ(axis.status.state, State::kIdle);
  EXPECT_EQ(axis.status.fault.fault, Fault::kNone);
  EXPECT_EQ(axis.status.fault.number, 1);
  ExpectSafe(axis);
  axis.Start(kMass, 0);
  axis.Run();
  EXPECT_EQ(axis.status.state, State::kRendering);
}

TEST(SupervisorFaultTest, LatchesAFaultWhoseNumberWasClearedBeforeItCame) {
  Axis axis;
  axis.settings.cleared_fault_number = 7;
  axis.EmergencyStop();
  axis.RunTicks(10);
  EXPECT_EQ(axis.status.state, State::kFault);
  EXPECT_EQ(axis.status.fault.number, 8);
}

TEST(SupervisorFaultTest, TellsWhyADriveIsNotEnabled) {
  const std::pair<device::Enabling, Fault> reasons[] = {
      {device::Enabling::kSilent, Fault::kDriveSilent},
      {device::Enabling::kNoWatchdog, Fault::kNoDriveWatchdog},
      {device::Enabling::kForeignTraffic, Fault::kForeignTraffic}};
  for (const auto& [refusal, fault] : reasons) {
    Axis axis;
    axis.drive.accepts_enable = false;
    axis.drive.refusal = refusal;
    axis.Start(kMass, 0);
    axis.Run();
    EXPECT_EQ(axis.status.fault.fault, fault);
    ExpectSafe(axis);
  }
}

TEST(SupervisorFaultTest, FaultsWhereTheDriveRefusesToBeEnabled) {
  Axis axis;
  axis.drive.accepts_enable = false;
  axis.Start(kMass, 0);
  axis.Run();
  ExpectFault(axis, Fault::kDriveRefused, 0, 0);
  ExpectSafe(axis);
  EXPECT_EQ(axis.drive.disables, 1);
  EXPECT_EQ(axis.status.render_epoch, 0);
  EXPECT_EQ(axis.status.renderings_ended, 0);
}

TEST(SupervisorFaultTest, RampsToZeroWithinTheFaultRampBeyondAPositionLimit) {
  for (const double limit : {-1.0, 1.0}) {
    Axis axis;
    axis.Start(kMass, 0);
    axis.SetPosition(0.999 * limit);
    axis.RunTicks(100);
    ASSERT_EQ(axis.status.state, State::kRendering);
    axis.SetPosition(1.001 * limit);
    axis.Run();
    ExpectFault(axis, Fault::kPositionLimit, 1.001 * limit, limit);
    EXPECT_EQ(axis.status.renderings_ended, 1);
    EXPECT_NEAR(axis.status.mass, kMass * 49 / 50, 1e-15);
    EXPECT_TRUE(axis.drive.enabled);
    EXPECT_NE(axis.drive.acting_counts, 0);
    axis.RunTicks(48);
    EXPECT_NEAR(axis.status.mass, kMass / 50, 1e-15);
    axis.Run();
    ExpectSafe(axis);
  }
}

TEST(SupervisorFaultTest, FaultsBeyondTheVelocityLimit) {
  Axis axis;
  axis.Start(kMass, 0);
  axis.SetPosition(0);
  axis.RunTicks(10);
  axis.SetPosition(-0.003);  // In two steps: in one it would be no motion, but an encoder that jumps.
  axis.Run();
  axis.SetPosition(-0.00801);
  axis.Run();
  EXPECT_EQ(axis.status.fault.fault, Fault::kVelocityLimit);
  EXPECT_NEAR(axis.status.fault.value, -5.01, 1e-9);
  EXPECT_EQ(axis.status.fault.limit, 5);
  axis.RunTicks(49);
  ExpectSafe(axis);
}

TEST(SupervisorFaultTest, ClearsAFaultOnlyAfterItsRamp) {
  Axis axis;
  axis.RenderSwinging(kMass);
  axis.MoveTo(1.001);
  axis.ClearFault();
  axis.RunTicks(48);
  EXPECT_EQ(axis.status.state, State::kFault);
  axis.RunTicks(2);
  EXPECT_EQ(axis.status.state, State::kIdle);
  ExpectSafe(axis);
}

TEST(SupervisorFaultTest, LetsTheArmBeAnywhereWithoutAForceButNotBeginThere) {
  Axis axis;
  axis.SetPosition(1.5);
  axis.RunTicks(10);
  EXPECT_EQ(axis.status.state, State::kIdle);
  axis.Start(kMass, 0.1);
  axis.Run();
  ExpectFault(axis, Fault::kPositionLimit, 1.5, 1);
  EXPECT_EQ(axis.drive.acting_counts, 0);
}

TEST(SupervisorFaultTest, FaultsWhereMoreTicksAreSkippedThanAllowed) {
  Axis axis;
  axis.RenderSwinging(kMass);
  axis.Swing(5);
  EXPECT_EQ(axis.status.state, State::kRendering);
  axis.Swing(6);
  ExpectFault(axis, Fault::kOverrun, 6, 5);
  ExpectSafe(axis);
}

TEST(SupervisorFaultTest, ForgivesSkippedTicksWhereThereIsNoForce) {
  Axis axis;
  axis.Run(1000);
  EXPECT_EQ(axis.status.state, State::kIdle);
}

TEST(SupervisorFaultTest, NeverRendersAMassThatIsNoNumber) {
  for (const double mass :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Axis axis;
    axis.RenderSwinging(kMass);
    axis.settings.mass = mass;
    axis.Post();
    axis.Swing();
    EXPECT_EQ(axis.status.fault.fault, Fault::kNotFinite);
    ExpectSafe(axis);

    Axis starting;
    starting.Start(mass, 0.1);
    starting.Run();
    EXPECT_EQ(starting.status.fault.fault, Fault::kNotFinite);
    EXPECT_TRUE(starting.status.fault.value == mass ||
                (std::isnan(mass) && std::isnan(starting.status.fault.value)));
    ExpectSafe(starting);
  }
}

TEST(SupervisorFaultTest, FaultsWhereAMotionOrAForceIsNoNumber) {
  Axis motion;
  motion.drive.info.position_quantum = 1e300;
  Tick tick(motion.config, motion.drive, *motion.crossing);
  motion.Start(kMass, 0);
  tick.Run(1, 1, 0);
  motion.drive.position_counts = 1'000'000'000'000;
  tick.Run(2, 2, 0);
  motion.crossing->status.Take(motion.status);
  EXPECT_EQ(motion.status.fault.fault, Fault::kNotFinite);
  EXPECT_EQ(motion.drive.acting_counts, 0);

  Axis force;
  force.RenderSwinging(kMass);
  force.settings.mass = std::numeric_limits<double>::max();
  force.Post();
  force.Swing();
  EXPECT_EQ(force.status.fault.fault, Fault::kNotFinite);
  EXPECT_TRUE(std::isinf(force.status.fault.value));
  ExpectSafe(force);
}

}  // namespace
}  // namespace mwidth::render
