#include "device/emulator/joint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "server/model/hybrid_simulation.h"

namespace mwidth::device::emulator {
namespace {

constexpr int64_t kMs = 1'000'000;

/// A hand that stays where it is.
class Still final : public HandMotion {
 public:
  double PositionAt(double /*time_s*/) const noexcept override { return 0; }
};

JointConfig Config() {
  return {.plant = {.device_mass = 0.2,
                    .device_damping = 0.1,
                    .hand_damping = 1,
                    .hand_stiffness = 25,
                    .period_s = 1e-3,
                    .cutoff_hz = 10},
          .position_quantum = 1e-6,
          .force_quantum = 1e-3,
          .watchdog_s = 0.05};
}

TEST(EmulatedJoint, YieldsToItsMotorAsTheEquationOfMotionSays) {
  Joint joint(Config(), std::make_unique<Still>());
  joint.PositionCounts(1);
  joint.SetEnabled(1, true);
  joint.SetForce(1, 500);
  // The static deflection: 0.5 N against 25 N/m.
  EXPECT_NEAR(static_cast<double>(joint.PositionCounts(10'000 * kMs)) * 1e-6, 0.5 / 25, 1e-6);
  // On the way there, x(t) of m x'' + b x' + k x = F from rest, by its damped sinusoid.
  Joint again(Config(), std::make_unique<Still>());
  again.PositionCounts(1);
  again.SetEnabled(1, true);
  again.SetForce(1, 500);
  const double decay = 1.1 / (2 * 0.2);
  const double frequency = std::sqrt(25 / 0.2 - decay * decay);
  for (const double time_s : {0.05, 0.2, 0.7}) {
    const double wave = std::cos(frequency * time_s) + decay / frequency * std::sin(frequency * time_s);
    const double expected = 0.02 * (1 - std::exp(-decay * time_s) * wave);
    // Time counts in whole steps.
    const double step_m = 0.02 * frequency * Joint::kStepS;
    EXPECT_NEAR(static_cast<double>(again.PositionCounts(static_cast<int64_t>(time_s * 1e9))) * 1e-6,
                expected, 2 * step_m);
  }
}

TEST(EmulatedJoint, TakesNoForceWhileDisabled) {
  Joint joint(Config(), std::make_unique<Still>());
  joint.SetForce(1, 500);
  EXPECT_EQ(joint.force_counts(), 0);
  joint.SetEnabled(2, true);
  EXPECT_EQ(joint.force_counts(), 0);
  joint.SetForce(3, 500);
  EXPECT_EQ(joint.force_counts(), 500);
  joint.SetEnabled(4, false);
  EXPECT_EQ(joint.force_counts(), 0);
}

TEST(EmulatedJoint, IsDisabledByItsWatchdogWhenNobodyAsks) {
  Joint joint(Config(), std::make_unique<Still>());
  joint.Feed(1);
  joint.SetEnabled(1, true);
  joint.SetForce(1, 500);
  joint.Turn(40 * kMs);
  joint.Feed(40 * kMs);
  joint.Turn(80 * kMs);
  EXPECT_TRUE(joint.enabled());
  joint.Turn(91 * kMs);
  EXPECT_FALSE(joint.enabled());
  EXPECT_EQ(joint.force_counts(), 0);
  joint.Turn(200 * kMs);
  EXPECT_EQ(joint.trips().count, 1);
  EXPECT_EQ(joint.trips().after_s, 0.05);
}

TEST(EmulatedJoint, IsDisabledOnTheTimeOutHoweverLateAnybodyLooks) {
  const auto position = [](int64_t first_look_ns) {
    Joint joint(Config(), std::make_unique<Still>());
    joint.Feed(1);
    joint.SetEnabled(1, true);
    joint.SetForce(1, 500);
    joint.Turn(first_look_ns);
    return joint.PositionCounts(150 * kMs);
  };
  EXPECT_EQ(position(51 * kMs), position(150 * kMs));
  // Had the force acted for longer, it would show.
  JointConfig patient = Config();
  patient.watchdog_s = 0;
  Joint joint(patient, std::make_unique<Still>());
  joint.SetEnabled(1, true);
  joint.SetForce(1, 500);
  EXPECT_GT(joint.PositionCounts(150 * kMs), position(150 * kMs) + 1000);
}

TEST(EmulatedJoint, ShowsWrongPositionsOnDemand) {
  Joint joint(Config(), std::make_unique<Still>());
  joint.JumpEncoder(1000);
  EXPECT_EQ(joint.PositionCounts(1), 1000);
  joint.SetEncoderFault(EncoderFault::kFrozen);
  joint.SetEnabled(2, true);
  joint.SetForce(2, 500);
  EXPECT_EQ(joint.PositionCounts(1000 * kMs), 1000);
  joint.SetEncoderFault(EncoderFault::kNone);
  EXPECT_NE(joint.PositionCounts(1001 * kMs), 1000);
}

}  // namespace
}  // namespace mwidth::device::emulator
