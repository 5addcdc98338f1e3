#include "device/emulator/power_state.h"

#include <gtest/gtest.h>

namespace mwidth::device::emulator {
namespace {

constexpr int64_t kStep = PowerStateMachine::kStepNs;

// Commands of CiA 402-2, table "Command coding".
constexpr uint16_t kShutdown = 0x06;
constexpr uint16_t kSwitchOn = 0x07;
constexpr uint16_t kEnableOperation = 0x0F;
constexpr uint16_t kDisableVoltage = 0x00;
constexpr uint16_t kQuickStop = 0x02;
constexpr uint16_t kFaultReset = 0x80;

class PowerStateTest : public ::testing::Test {
 protected:
  PowerState After(int64_t pause_ns) {
    now += pause_ns;
    power.Turn(now);
    return power.state();
  }
  PowerState Command(uint16_t word) {
    power.Command(word, now);
    return power.state();
  }
  void Enable() {
    power.Turn(now);
    EXPECT_EQ(After(kStep), PowerState::kSwitchOnDisabled);
    Command(kShutdown);
    EXPECT_EQ(After(kStep), PowerState::kReadyToSwitchOn);
    Command(kSwitchOn);
    EXPECT_EQ(After(kStep), PowerState::kSwitchedOn);
    Command(kEnableOperation);
    EXPECT_EQ(After(kStep), PowerState::kOperationEnabled);
  }

  PowerStateMachine power;
  int64_t now = 1;
};

TEST_F(PowerStateTest, RisesStepByStepAndTakesItsTime) {
  power.Turn(now);
  EXPECT_EQ(After(kStep - 1), PowerState::kNotReadyToSwitchOn);
  EXPECT_EQ(After(1), PowerState::kSwitchOnDisabled);
  EXPECT_EQ(Command(kShutdown), PowerState::kSwitchOnDisabled);
  EXPECT_EQ(After(kStep - 1), PowerState::kSwitchOnDisabled);
  EXPECT_EQ(After(1), PowerState::kReadyToSwitchOn);
  // Two steps with one command, one after the other.
  EXPECT_EQ(Command(kEnableOperation), PowerState::kReadyToSwitchOn);
  EXPECT_EQ(After(kStep), PowerState::kSwitchedOn);
  EXPECT_EQ(After(0), PowerState::kSwitchedOn);
  EXPECT_EQ(After(kStep), PowerState::kOperationEnabled);
}

TEST_F(PowerStateTest, DoesNotRiseWithoutAShutdownBefore) {
  power.Turn(now);
  After(kStep);
  Command(kEnableOperation);
  After(kStep);
  EXPECT_EQ(After(kStep), PowerState::kSwitchOnDisabled);
}

TEST_F(PowerStateTest, TakesNoStepThatIsNotWantedAnyMore) {
  power.Turn(now);
  After(kStep);
  Command(kShutdown);
  After(kStep / 2);
  Command(kDisableVoltage);
  EXPECT_EQ(After(kStep), PowerState::kSwitchOnDisabled);
}

TEST_F(PowerStateTest, FallsAtOnce) {
  const auto falls = [this](uint16_t word) {
    power = PowerStateMachine();
    Enable();
    return Command(word);
  };
  EXPECT_EQ(falls(kSwitchOn), PowerState::kSwitchedOn);
  EXPECT_EQ(falls(kShutdown), PowerState::kReadyToSwitchOn);
  EXPECT_EQ(falls(kDisableVoltage), PowerState::kSwitchOnDisabled);
  EXPECT_EQ(falls(kQuickStop), PowerState::kSwitchOnDisabled);
}

TEST_F(PowerStateTest, StaysInAQuickStopForAStepWhereItBrakes) {
  power.SetQuickStopOption(2);
  Enable();
  EXPECT_EQ(Command(kQuickStop), PowerState::kQuickStopActive);
  EXPECT_EQ(Command(kEnableOperation), PowerState::kQuickStopActive);
  EXPECT_EQ(After(kStep), PowerState::kSwitchOnDisabled);
}

TEST_F(PowerStateTest, LeavesAFaultOnTheEdgeOfAResetAlone) {
  Enable();
  Command(kEnableOperation | kFaultReset);
  power.Fail();
  // The bit was there before.
  EXPECT_EQ(Command(kEnableOperation | kFaultReset), PowerState::kFault);
  EXPECT_EQ(After(2 * kStep), PowerState::kFault);
  Command(kDisableVoltage);
  EXPECT_EQ(After(2 * kStep), PowerState::kFault);
  Command(kFaultReset);
  EXPECT_EQ(After(kStep), PowerState::kSwitchOnDisabled);
}

TEST_F(PowerStateTest, ShowsItselfInTheStatusword) {
  // CiA 402-2, table "State coding": bits 6, 5 and 3 to 0.
  EXPECT_EQ(power.StatuswordBits() & 0x4F, 0x00);
  power.Turn(now);
  After(kStep);
  EXPECT_EQ(power.StatuswordBits() & 0x4F, 0x40);
  Command(kShutdown);
  After(kStep);
  EXPECT_EQ(power.StatuswordBits() & 0x6F, 0x21);
  Command(kSwitchOn);
  After(kStep);
  EXPECT_EQ(power.StatuswordBits() & 0x6F, 0x23);
  Command(kEnableOperation);
  After(kStep);
  EXPECT_EQ(power.StatuswordBits() & 0x6F, 0x27);
  power.SetQuickStopOption(1);
  Command(kQuickStop);
  EXPECT_EQ(power.StatuswordBits() & 0x6F, 0x07);
  power.Fail();
  EXPECT_EQ(power.StatuswordBits() & 0x4F, 0x08);
}

}  // namespace
}  // namespace mwidth::device::emulator
