// What must hold when things go wrong: stops, faults, lost leases, silent loops, many threads.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "server/gate/axis_gate.h"
#include "tests/server/gate/axis_fixture.h"

namespace mwidth::gate {
namespace {

using exchange::State;

class AxisGateSafetyTest : public AxisFixture {
 protected:
  /// Starts again, after whatever happened, and returns the mass that the loop began with.
  double MassOfNextStart(const std::string& lease) {
    if (loop.status().state == State::kFault) {
      EXPECT_TRUE(gate.ClearFault(lease).ok());
    }
    EXPECT_TRUE(gate.StartRendering(lease).ok());
    EXPECT_EQ(loop.status().state, State::kRendering);
    return loop.status().target_mass;
  }
};

TEST_F(AxisGateSafetyTest, AStopForgetsTheMass) {
  const std::string lease = Render(0.5);
  ASSERT_TRUE(gate.StopRendering(lease).ok());
  EXPECT_EQ(MassOfNextStart(lease), 0);
}

TEST_F(AxisGateSafetyTest, AStopForgetsAMassThatWasOnlyKept) {
  const std::string lease = Acquire();
  ASSERT_TRUE(gate.SetMass(lease, {.mass = 0.5}).ok());
  ASSERT_TRUE(gate.StopRendering(lease).ok());
  EXPECT_EQ(MassOfNextStart(lease), 0);
}

TEST_F(AxisGateSafetyTest, AFaultForgetsTheMass) {
  const std::string lease = Render(0.5);
  loop.Trip(exchange::Fault::kVelocityLimit);
  loop.Tick();
  EXPECT_EQ(MassOfNextStart(lease), 0);
}

TEST_F(AxisGateSafetyTest, AFaultBeforeTheStartForgetsAMassThatWasOnlyKept) {
  const std::string lease = Acquire();
  ASSERT_TRUE(gate.SetMass(lease, {.mass = 0.5}).ok());
  loop.Trip(exchange::Fault::kDriveSilent);
  loop.Tick();
  EXPECT_EQ(MassOfNextStart(lease), 0);
}

TEST_F(AxisGateSafetyTest, AnEmergencyStopForgetsTheMass) {
  const std::string lease = Render(0.5);
  EmergencyStop();
  EXPECT_EQ(MassOfNextStart(lease), 0);
}

TEST_F(AxisGateSafetyTest, ARenderingThatTheLoopEndedByItselfForgetsTheMass) {
  const std::string lease = Render(0.5);
  // The loop runs late and sees the renewal only after it has seen the lease expire.
  clock.AdvanceS(0.999);
  loop.Tick();
  clock.AdvanceS(0.002);
  for (int i = 0; i < FakeLoop::kEndTicks; ++i) {
    loop.Tick();
  }
  EXPECT_EQ(loop.status().state, State::kReady);
  ExpectRefused(gate.RenewControl(lease), RefusalCode::kFailedPrecondition, kNoLease);
  EXPECT_EQ(MassOfNextStart(gate.AcquireControl("test", 1)->id), 0);
}

TEST_F(AxisGateSafetyTest, AMassWhoseLeaseExpiresWhileItIsJudgedIsRefused) {
  const std::string lease = Render(0.5);
  clock.AdvanceAfterNextLookS(1);
  ExpectRefused(gate.SetMass(lease, {.mass = 0.1}), RefusalCode::kFailedPrecondition, kNoLease);
  EXPECT_EQ(loop.settings().mass, 0.5);
}

TEST_F(AxisGateSafetyTest, AnotherHolderMeetsNoMassOfTheFirst) {
  const std::string first = Acquire();
  ASSERT_TRUE(gate.SetMass(first, {.mass = 0.5}).ok());
  ASSERT_TRUE(gate.ReleaseControl(first).ok());
  EXPECT_EQ(MassOfNextStart(gate.AcquireControl("other", 1)->id), 0);
}

TEST_F(AxisGateSafetyTest, ANewLeaseEndsARenderingWhoseExpiryTheLoopHasNotSeen) {
  Render(0.5);
  clock.AdvanceS(1.5);
  const Result<Lease> other = gate.AcquireControl("other", 1);
  ASSERT_TRUE(other.ok());
  ExpectRefused(gate.StartRendering(other->id), RefusalCode::kFailedPrecondition, kWrongState);
  for (int i = 0; i < FakeLoop::kEndTicks; ++i) {
    loop.Tick();
  }
  EXPECT_EQ(loop.status().state, State::kReady);
  EXPECT_EQ(MassOfNextStart(other->id), 0);
}

TEST_F(AxisGateSafetyTest, AKeptMassSurvivesNothingButTheWait) {
  const std::string lease = Acquire();
  ASSERT_TRUE(gate.SetMass(lease, {.mass = 0.5}).ok());
  ASSERT_TRUE(gate.SetMass(lease, {.mass = 40}).ok() == false);
  ASSERT_TRUE(gate.RenewControl(lease).ok());
  EXPECT_EQ(MassOfNextStart(lease), 0.5);
}

TEST_F(AxisGateSafetyTest, AnEmergencyStopNeedsNoLeaseInAnyState) {
  for (int i = 0; i < 2; ++i) {
    const Result<exchange::LoopStatus> stopped = gate.AwaitEmergencyStop(gate.PostEmergencyStop());
    ASSERT_TRUE(stopped.ok());
    EXPECT_EQ(stopped->state, State::kFault);
    EXPECT_EQ(stopped->fault.fault, exchange::Fault::kEmergencyStop);
  }
}

TEST_F(AxisGateSafetyTest, AnEmergencyStopIsPostedWhileAnotherCommandWaits) {
  const std::string lease = Acquire();
  bool stopped = false;
  meanwhile = [&] {
    gate.PostEmergencyStop();
    loop.Tick();
    stopped = loop.status().state == State::kFault;
  };
  ExpectRefused(gate.StartRendering(lease), RefusalCode::kFailedPrecondition, kWrongState);
  EXPECT_TRUE(stopped);
}

TEST_F(AxisGateSafetyTest, AMassThatMeetsAFaultOnItsWayIsRefused) {
  const std::string lease = Render(0.5);
  meanwhile = [&] { loop.Trip(exchange::Fault::kVelocityLimit); };
  ExpectRefused(gate.SetMass(lease, {.mass = 0.1}), RefusalCode::kFailedPrecondition, kWrongState);
}

TEST_F(AxisGateSafetyTest, ASilentLoopIsReportedAndToldToStop) {
  const std::string lease = Render(0.5);
  silent = true;
  ExpectRefused(gate.SetMass(lease, {.mass = 0.1}), RefusalCode::kUnavailable, kLoopSilent);
  loop.Tick();
  EXPECT_FALSE(loop.settings().rendering);
  EXPECT_EQ(loop.settings().mass, 0);
}

TEST_F(AxisGateSafetyTest, ASilentLoopIsReportedByEveryCommandThatWaits) {
  const std::string lease = Acquire();
  silent = true;
  ExpectRefused(gate.StartRendering(lease), RefusalCode::kUnavailable, kLoopSilent);
  ExpectRefused(gate.StopRendering(lease), RefusalCode::kUnavailable, kLoopSilent);
  ExpectRefused(gate.AwaitEmergencyStop(gate.PostEmergencyStop()), RefusalCode::kUnavailable, kLoopSilent);
  ExpectRefused(gate.ReleaseControl(lease), RefusalCode::kUnavailable, kLoopSilent);
  EXPECT_EQ(gate.Controller(), "");
}

TEST_F(AxisGateSafetyTest, AStartThatWasRefusedDoesNotHappenLater) {
  const std::string lease = Acquire();
  silent = true;
  ExpectRefused(gate.StartRendering(lease), RefusalCode::kUnavailable, kLoopSilent);
  loop.Tick();
  EXPECT_EQ(loop.status().state, State::kIdle);
}

TEST_F(AxisGateSafetyTest, AStartThatTheLoopIgnoresIsRefusedAndTakenBack) {
  const std::string lease = Acquire();
  loop.IgnoreStarts();
  ExpectRefused(gate.StartRendering(lease), RefusalCode::kFailedPrecondition, kWrongState);
  loop.Tick();
  EXPECT_FALSE(loop.settings().rendering);
}

TEST_F(AxisGateSafetyTest, ManyThreadsLeaveOneHolderAndAConsistentLoop) {
  FakeLoop busy(*crossing, clock);
  std::atomic<bool> over{false};
  std::thread ticking([&] {
    while (!over) {
      busy.Tick();
      std::this_thread::yield();
    }
  });
  // The loop ticks for as long as anyone waits.
  AxisGate shared(PaperAxis(), *crossing, clock, [](const std::function<bool()>& done) {
    while (!done()) {
      std::this_thread::yield();
    }
    return true;
  });
  std::atomic<int> held{0};
  std::vector<std::thread> clients;
  clients.reserve(4);
  for (int client = 0; client < 4; ++client) {
    clients.emplace_back([&, client] {
      for (int i = 0; i < 50; ++i) {
        const Result<Lease> lease = shared.AcquireControl("client", 60);
        if (!lease.ok()) {
          shared.Status();
          continue;
        }
        EXPECT_EQ(held.fetch_add(1), 0) << client;
        EXPECT_TRUE(shared.SetMass(lease->id, {.mass = 0.01 * client}).ok());
        held.fetch_sub(1);
        EXPECT_TRUE(shared.ReleaseControl(lease->id).ok());
      }
    });
  }
  for (std::thread& client : clients) {
    client.join();
  }
  over = true;
  ticking.join();
  EXPECT_EQ(busy.status().state, State::kIdle);
}

}  // namespace
}  // namespace mwidth::gate
