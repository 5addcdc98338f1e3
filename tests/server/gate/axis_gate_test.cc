#include "server/gate/axis_gate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "tests/server/gate/axis_fixture.h"

namespace mwidth::gate {
namespace {

using exchange::State;
using testing::HasSubstr;

class AxisGateTest : public AxisFixture {};

TEST_F(AxisGateTest, RendersAMassThatWasKeptForTheStart) {
  const std::string lease = Acquire();
  const Result<MassGrant> grant = gate.SetMass(lease, {.mass = 0.5, .ramp_s = 0.3});
  ASSERT_TRUE(grant.ok());
  EXPECT_EQ(grant->mass, 0.5);
  EXPECT_EQ(grant->tick, loop.status().tick);
  EXPECT_TRUE(grant->stability.admitted);
  EXPECT_EQ(loop.status().state, State::kIdle);
  const Result<exchange::LoopStatus> started = gate.StartRendering(lease);
  ASSERT_TRUE(started.ok());
  EXPECT_EQ(started->state, State::kRendering);
  EXPECT_EQ(loop.status().mass, 0.5);
  EXPECT_EQ(loop.settings().ramp_s, 0.3);
}

TEST_F(AxisGateTest, ChangesTheMassWhileRendering) {
  const std::string lease = Render(0.5);
  ASSERT_TRUE(gate.SetMass(lease, {.mass = -0.02}).ok());
  EXPECT_EQ(loop.status().mass, -0.02);
  EXPECT_EQ(loop.status().state, State::kRendering);
}

TEST_F(AxisGateTest, LeavesTheMassAloneWhenItRefusesAnother) {
  const std::string lease = Render(0.5);
  const auto before = loop.settings().sequence;
  ExpectRefused(gate.SetMass(lease, {.mass = 40}), RefusalCode::kFailedPrecondition, kUnstableMass);
  ExpectRefused(gate.SetMass(lease, {.mass = 51}), RefusalCode::kInvalidArgument, kMassLimit);
  ExpectRefused(gate.SetMass(lease, {.mass = std::numeric_limits<double>::quiet_NaN()}),
                RefusalCode::kInvalidArgument, kInvalidNumber);
  ExpectRefused(gate.SetMass(lease, {.mass = 0.1, .ramp_s = std::numeric_limits<double>::infinity()}),
                RefusalCode::kInvalidArgument, kInvalidNumber);
  loop.Tick();
  EXPECT_EQ(loop.settings().sequence, before);
  EXPECT_EQ(loop.status().mass, 0.5);
}

TEST_F(AxisGateTest, TellsHowTrulyAndHowQuietlyAMassIsRendered) {
  const Result<MassGrant> grant = gate.SetMass(Acquire(), {.mass = 0.21});
  ASSERT_TRUE(grant.ok());
  EXPECT_NEAR(grant->accuracy.ideal_mass, 0.28, 1e-15);
  EXPECT_NEAR(grant->accuracy.error.value(), -0.100, 1e-3);
  EXPECT_GT(grant->accuracy.force_noise.value(), 0);
  EXPECT_EQ(grant->accuracy.unavailable_reason, "");
  EXPECT_FALSE(grant->accuracy.simulated_error.has_value());
}

class NoisyAxisTest : public AxisFixture {
 protected:
  static AxisDescription NoisyAxis() {
    AxisDescription axis = PaperAxis();
    axis.force_noise_limit = 0.01;
    return axis;
  }
  NoisyAxisTest() : AxisFixture(NoisyAxis()) {}
};

TEST_F(NoisyAxisTest, LeavesTheMassAloneWhenItRefusesANoisyOne) {
  const std::string lease = Render(0.1);
  const auto before = loop.settings().sequence;
  const Result<MassGrant> refused = gate.SetMass(lease, {.mass = 1.5});
  ExpectRefused(refused, RefusalCode::kFailedPrecondition, kNoisyMass);
  loop.Tick();
  EXPECT_EQ(loop.settings().sequence, before);
  EXPECT_TRUE(gate.SetMass(lease, {.mass = refused.refusal().stability->nearest_admitted_mass}).ok());
}

TEST_F(AxisGateTest, JudgesWithoutChangingWhenAskedOnlyToValidate) {
  const std::string lease = Render(0.5);
  const auto before = loop.settings().sequence;
  const Result<MassGrant> grant = gate.SetMass(lease, {.mass = 0.1, .validate_only = true});
  ASSERT_TRUE(grant.ok());
  EXPECT_EQ(grant->tick, 0U);
  ExpectRefused(gate.SetMass(lease, {.mass = 40, .validate_only = true}), RefusalCode::kFailedPrecondition,
                kUnstableMass);
  loop.Tick();
  EXPECT_EQ(loop.settings().sequence, before);
}

TEST_F(AxisGateTest, AsksForTheLeaseBeforeAnythingElse) {
  loop.Tick();
  for (const char* lease : {"", "0123456789abcdef0123456789abcdef"}) {
    const auto code = RefusalCode::kFailedPrecondition;
    ExpectRefused(gate.SetMass(lease, {.mass = std::numeric_limits<double>::quiet_NaN()}), code, kNoLease);
    ExpectRefused(gate.StartRendering(lease), code, kNoLease);
    ExpectRefused(gate.StopRendering(lease), code, kNoLease);
    ExpectRefused(gate.ClearFault(lease), code, kNoLease);
    ExpectRefused(gate.RenewControl(lease), code, kNoLease);
    ExpectRefused(gate.ReleaseControl(lease), code, kNoLease);
  }
  loop.Tick();
  EXPECT_EQ(loop.settings().sequence, 0U);
}

TEST_F(AxisGateTest, ReportsALeaseThatAnotherHasTakenAsLost) {
  const std::string lease = Render(0.5);
  clock.AdvanceS(1);
  ASSERT_TRUE(gate.AcquireControl("other", 1).ok());
  ExpectRefused(gate.SetMass(lease, {.mass = 0.1}), RefusalCode::kAborted, kLeaseLost);
  ExpectRefused(gate.RenewControl(lease), RefusalCode::kAborted, kLeaseLost);
}

TEST_F(AxisGateTest, PostsTheDeadMansDeadlineWithEachLeaseAndRenewal) {
  const std::string lease = Acquire();
  loop.Tick();
  EXPECT_EQ(loop.settings().lease_deadline_ns, clock.NowNs() + 1'000'000'000);
  clock.AdvanceS(0.7);
  ASSERT_TRUE(gate.RenewControl(lease).ok());
  loop.Tick();
  EXPECT_EQ(loop.settings().lease_deadline_ns, clock.NowNs() + 1'000'000'000);
}

TEST_F(AxisGateTest, SaysWhoHasControl) {
  EXPECT_EQ(gate.Controller(), "");
  const std::string lease = Acquire();
  EXPECT_EQ(gate.Controller(), "test");
  ExpectRefused(gate.AcquireControl("other", 1), RefusalCode::kFailedPrecondition, kControlHeld);
  ASSERT_TRUE(gate.ReleaseControl(lease).ok());
  EXPECT_EQ(gate.Controller(), "");
}

TEST_F(AxisGateTest, StopsAndWaitsForTheRampToEnd) {
  const std::string lease = Render(0.5);
  const Result<exchange::LoopStatus> stopped = gate.StopRendering(lease);
  ASSERT_TRUE(stopped.ok());
  EXPECT_EQ(stopped->state, State::kReady);
  EXPECT_EQ(stopped->mass, 0);
  EXPECT_TRUE(gate.StopRendering(lease).ok());
}

TEST_F(AxisGateTest, RampsDownWhenControlIsReleased) {
  const std::string lease = Render(0.5);
  const Result<exchange::LoopStatus> released = gate.ReleaseControl(lease);
  ASSERT_TRUE(released.ok());
  EXPECT_EQ(released->state, State::kReady);
  ExpectRefused(gate.StartRendering(lease), RefusalCode::kFailedPrecondition, kNoLease);
}

TEST_F(AxisGateTest, RefusesToStartWhatRendersAlready) {
  const std::string lease = Render(0.5);
  ExpectRefused(gate.StartRendering(lease), RefusalCode::kFailedPrecondition, kWrongState);
  EXPECT_EQ(loop.status().mass, 0.5);
}

TEST_F(AxisGateTest, RefusesMassesAndStartsWhileAStopRampsDown) {
  const std::string lease = Render(0.5);
  meanwhile = [&] {
    loop.Tick();
    ExpectRefused(gate.SetMass(lease, {.mass = 0.1}), RefusalCode::kFailedPrecondition, kWrongState);
    ExpectRefused(gate.StartRendering(lease), RefusalCode::kFailedPrecondition, kWrongState);
  };
  ASSERT_TRUE(gate.StopRendering(lease).ok());
  EXPECT_EQ(loop.status().state, State::kReady);
}

TEST_F(AxisGateTest, RefusesASecondStartWhileTheFirstIsPending) {
  const std::string lease = Acquire();
  meanwhile = [&] {
    ExpectRefused(gate.StartRendering(lease), RefusalCode::kFailedPrecondition, kWrongState);
  };
  EXPECT_TRUE(gate.StartRendering(lease).ok());
}

TEST_F(AxisGateTest, ClearsTheFaultThatIsLatched) {
  const std::string lease = Render(0.5);
  ExpectRefused(gate.ClearFault(lease), RefusalCode::kFailedPrecondition, kWrongState);
  loop.Trip(exchange::Fault::kVelocityLimit);
  loop.Tick();
  const Result<MassGrant> refused = gate.SetMass(lease, {.mass = 0.1});
  ExpectRefused(refused, RefusalCode::kFailedPrecondition, kWrongState);
  EXPECT_EQ(refused.refusal().metadata.at("state"), "FAULT");
  EXPECT_THAT(refused.refusal().message, HasSubstr("velocity"));
  ExpectRefused(gate.StartRendering(lease), RefusalCode::kFailedPrecondition, kWrongState);
  const Result<exchange::LoopStatus> cleared = gate.ClearFault(lease);
  ASSERT_TRUE(cleared.ok());
  EXPECT_EQ(cleared->state, State::kIdle);
}

TEST_F(AxisGateTest, WaitsForAFaultThatStillRampsDown) {
  const std::string lease = Render(0.5);
  loop.Trip(exchange::Fault::kPositionLimit);
  loop.HoldFaults(4);
  loop.Tick();
  EXPECT_TRUE(gate.ClearFault(lease).ok());
  EXPECT_EQ(loop.status().state, State::kIdle);
}

TEST_F(AxisGateTest, DoesNotClearAFaultThatComesMeanwhile) {
  const std::string lease = Render(0.5);
  loop.Trip(exchange::Fault::kVelocityLimit);
  loop.Tick();
  meanwhile = [&] { loop.Trip(exchange::Fault::kPositionLimit); };
  const Result<exchange::LoopStatus> cleared = gate.ClearFault(lease);
  ExpectRefused(cleared, RefusalCode::kFailedPrecondition, kWrongState);
  EXPECT_THAT(cleared.refusal().message, HasSubstr("position"));
  EXPECT_EQ(loop.status().state, State::kFault);
}

TEST_F(AxisGateTest, ReportsADriveThatRefusesToStart) {
  const std::string lease = Acquire();
  loop.RefuseDrive();
  const Result<exchange::LoopStatus> started = gate.StartRendering(lease);
  ExpectRefused(started, RefusalCode::kFailedPrecondition, kWrongState);
  EXPECT_THAT(started.refusal().message, HasSubstr("could not be enabled"));
}

class BlockedAxisTest : public AxisFixture {
 protected:
  BlockedAxisTest() : AxisFixture(Axis()) {}

  static AxisDescription Axis() {
    AxisDescription axis = PaperAxis();
    axis.rendering_blocked_reason = "Real-time scheduling was refused: start with --allow-non-realtime.";
    return axis;
  }
};

TEST_F(BlockedAxisTest, RendersNothingAndSaysWhy) {
  const std::string lease = Acquire();
  EXPECT_TRUE(gate.SetMass(lease, {.mass = 0.1}).ok());
  const Result<exchange::LoopStatus> started = gate.StartRendering(lease);
  ExpectRefused(started, RefusalCode::kFailedPrecondition, kRenderingBlocked);
  EXPECT_EQ(started.refusal().message, Axis().rendering_blocked_reason);
  EXPECT_FALSE(loop.settings().rendering);
}

TEST(AxisGate, RefusesADescriptionThatContradictsItself) {
  const FakeClock clock;
  const auto crossing = std::make_unique<exchange::Crossing>();
  AxisDescription no_zero = PaperAxis();
  no_zero.mass_min = 0.1;
  EXPECT_THROW(AxisGate(no_zero, *crossing, clock), std::invalid_argument);
  AxisDescription no_loop = PaperAxis();
  no_loop.loop.device_mass = -1;
  EXPECT_THROW(AxisGate(no_loop, *crossing, clock), std::invalid_argument);
}

}  // namespace
}  // namespace mwidth::gate
