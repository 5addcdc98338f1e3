// The state machine, through the tick that runs it: what counts is what the drive gets.
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

TEST(SupervisorTest, TakesTheForceAwayInTheTickOfAnEmergencyStopFromAnyState) {
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
        axis.SetPosition(1.001);
        axis.Run();
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

TEST(SupervisorTest, NumbersAnEmergencyStopAboveTheFaultBeforeSoThatClearingThatOneDoesNotClearIt) {
  Axis axis;
  axis.RenderSwinging(kMass);
  axis.SetPosition(1.001);
  axis.Run();
  const uint64_t position_fault = axis.status.fault.number;
  axis.EmergencyStop();
  axis.RunTicks(100);
  axis.settings.cleared_fault_number = position_fault;
  axis.Post();
  axis.RunTicks(100);
  ExpectFault(axis, Fault::kEmergencyStop, 1, 0);
  EXPECT_EQ(axis.status.fault.number, position_fault + 1);
}

TEST(SupervisorTest, ObeysAnEmergencyStopFromBeforeTheLoop) {
  Axis axis;
  axis.EmergencyStop();
  Tick again(axis.config, axis.drive, *axis.crossing);
  again.Run(1, 1, 0);
  axis.crossing->status.Take(axis.status);
  ExpectFault(axis, Fault::kEmergencyStop, 1, 0);
}

TEST(SupervisorTest, LatchesAFaultUntilItIsClearedAndThenWaitsInIdle) {
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

TEST(SupervisorTest, LatchesAFaultWhoseNumberWasClearedBeforeItCame) {
  Axis axis;
  axis.settings.cleared_fault_number = 7;
  axis.EmergencyStop();
  axis.RunTicks(10);
  EXPECT_EQ(axis.status.state, State::kFault);
  EXPECT_EQ(axis.status.fault.number, 8);
}

TEST(SupervisorTest, FaultsWhereTheDriveRefusesToBeEnabled) {
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

TEST(SupervisorTest, HoldsTheForceForTwoSilentTicksAndTakesItAwayInTheThird) {
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

TEST(SupervisorTest, GoesOnAfterASilenceOfTwoTicks) {
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

TEST(SupervisorTest, CountsAForceThatTheDriveDidNotTakeAsSilence) {
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

TEST(SupervisorTest, CountsMissedTicksWithinASilenceAsSilent) {
  Axis axis;
  axis.RenderSwinging(kMass);
  axis.drive.answers_reads = false;
  axis.Swing(4);
  EXPECT_EQ(axis.status.state, State::kRendering);
  axis.Swing(4);
  ExpectFault(axis, Fault::kDriveSilent, 6, 2);
  ExpectSafe(axis);
}

TEST(SupervisorTest, LatchesSilenceInReadyButNotInIdle) {
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

TEST(SupervisorTest, FaultsAtOnceWhereAStartFindsTheDriveSilent) {
  Axis axis;
  axis.drive.answers_reads = false;
  axis.RunTicks(10);
  axis.Start(kMass, 0);
  axis.Run();
  ExpectFault(axis, Fault::kDriveSilent, 11, 2);
  ExpectSafe(axis);
}

TEST(SupervisorTest, RampsToZeroWithinTheFaultRampBeyondAPositionLimit) {
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

TEST(SupervisorTest, FaultsBeyondTheVelocityLimit) {
  Axis axis;
  axis.Start(kMass, 0);
  axis.SetPosition(0);
  axis.RunTicks(10);
  axis.SetPosition(-0.00501);
  axis.Run();
  EXPECT_EQ(axis.status.fault.fault, Fault::kVelocityLimit);
  EXPECT_NEAR(axis.status.fault.value, -5.01, 1e-9);
  EXPECT_EQ(axis.status.fault.limit, 5);
  axis.RunTicks(49);
  ExpectSafe(axis);
}

TEST(SupervisorTest, CutsTheRampOfAFaultWhenTheDriveFallsSilentInIt) {
  Axis axis;
  axis.RenderSwinging(kMass);
  axis.SetPosition(1.001);
  axis.Run();
  ASSERT_TRUE(axis.drive.enabled);
  axis.drive.answers_reads = false;
  axis.RunTicks(3);
  ExpectSafe(axis);
  EXPECT_EQ(axis.status.fault.fault, Fault::kPositionLimit);  // The cause stays.
  EXPECT_EQ(axis.status.fault.number, 1);
}

TEST(SupervisorTest, ClearsAFaultOnlyAfterItsRamp) {
  Axis axis;
  axis.RenderSwinging(kMass);
  axis.SetPosition(1.001);
  axis.Run();
  axis.ClearFault();
  axis.RunTicks(48);
  EXPECT_EQ(axis.status.state, State::kFault);
  axis.RunTicks(2);
  EXPECT_EQ(axis.status.state, State::kIdle);
  ExpectSafe(axis);
}

TEST(SupervisorTest, LetsTheArmBeAnywhereWithoutAForceButNotBeginThere) {
  Axis axis;
  axis.SetPosition(1.5);
  axis.RunTicks(10);
  EXPECT_EQ(axis.status.state, State::kIdle);
  axis.Start(kMass, 0.1);
  axis.Run();
  ExpectFault(axis, Fault::kPositionLimit, 1.5, 1);
  EXPECT_EQ(axis.drive.acting_counts, 0);
}

TEST(SupervisorTest, FaultsWhereMoreTicksAreSkippedThanAllowed) {
  Axis axis;
  axis.RenderSwinging(kMass);
  axis.Swing(5);
  EXPECT_EQ(axis.status.state, State::kRendering);
  axis.Swing(6);
  ExpectFault(axis, Fault::kOverrun, 6, 5);
  ExpectSafe(axis);
}

TEST(SupervisorTest, ForgivesSkippedTicksWhereThereIsNoForce) {
  Axis axis;
  axis.Run(1000);
  EXPECT_EQ(axis.status.state, State::kIdle);
}

TEST(SupervisorTest, NeverRendersAMassThatIsNoNumber) {
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

TEST(SupervisorTest, FaultsWhereAMotionOrAForceIsNoNumber) {
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
