// An axis gate with a loop that ticks only while the gate waits for it, or when the test says so.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>

#include "server/gate/axis_gate.h"
#include "tests/server/gate/fake_loop.h"

namespace mwidth::gate {

/// The paper's loop (Table II) with wide hard limits.
inline AxisDescription PaperAxis() {
  return {.name = "paper",
          .kind = model::AxisKind::kLinear,
          .loop = {.device_mass = 0.07,
                   .device_damping = 0.005,
                   .hand_mass = 0,
                   .hand_damping = 5,
                   .hand_stiffness = 700,
                   .period_s = 1e-3,
                   .cutoff_hz = 10,
                   .delay_s = 0},
          .mass_min = -50,
          .mass_max = 50,
          .force_limit = 20,
          .required_gain_margin_db = 3,
          .position_quantum = 1e-6,
          .force_noise_limit = {},
          .simulated = true,
          .realtime = true,
          .realtime_message = {},
          .rendering_blocked_reason = {}};
}

class AxisFixture : public testing::Test {
 protected:
  static constexpr int kPatienceTicks = 10;

  explicit AxisFixture(AxisDescription axis = PaperAxis())
      : gate(std::move(axis), *crossing, clock,
             [this](const std::function<bool()>& done) { return Wait(done); }) {}

  std::string Acquire() {
    loop.Tick();
    return gate.AcquireControl("test", 1).value().id;
  }

  /// A lease whose axis renders `mass`.
  std::string Render(double mass) {
    const std::string lease = Acquire();
    EXPECT_TRUE(gate.SetMass(lease, {.mass = mass}).ok());
    EXPECT_TRUE(gate.StartRendering(lease).ok());
    EXPECT_EQ(loop.status().mass, mass);
    return lease;
  }

  void EmergencyStop() { EXPECT_TRUE(gate.AwaitEmergencyStop(gate.PostEmergencyStop()).ok()); }

  FakeClock clock;
  // On the heap: its ring is large.
  std::unique_ptr<exchange::Crossing> crossing = std::make_unique<exchange::Crossing>();
  FakeLoop loop{*crossing, clock};
  bool silent = false;
  // Called once while the gate waits, in place of what another thread would do meanwhile.
  std::function<void()> meanwhile;
  AxisGate gate;

 private:
  bool Wait(const std::function<bool()>& done) {
    for (int tick = 0; tick < kPatienceTicks && !done(); ++tick) {
      if (meanwhile) {
        std::exchange(meanwhile, nullptr)();
      }
      if (!silent) {
        loop.Tick();
      }
    }
    return done();
  }
};

/// Expects a refusal with this code and reason.
template <typename T>
void ExpectRefused(const Result<T>& result, RefusalCode code, const std::string& reason) {
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.refusal().code, code);
  EXPECT_EQ(result.refusal().reason, reason);
  EXPECT_FALSE(result.refusal().message.empty());
}

}  // namespace mwidth::gate
