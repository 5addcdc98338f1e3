#include "device/emulator/power_state.h"

namespace mwidth::device::emulator {
namespace {

// Bits of the controlword.
constexpr uint16_t kSwitchOn = 0x01;
constexpr uint16_t kEnableVoltage = 0x02;
constexpr uint16_t kNoQuickStop = 0x04;
constexpr uint16_t kEnableOperation = 0x08;
constexpr uint16_t kFaultReset = 0x80;

bool Has(uint16_t word, uint16_t bits) { return (word & bits) == bits; }

}  // namespace

void PowerStateMachine::Enter(PowerState state) {
  state_ = state;
  step_ends_ns_ = 0;
}

void PowerStateMachine::Command(uint16_t controlword, int64_t now_ns) {
  const bool rises = Has(controlword, kFaultReset) && !Has(controlword_, kFaultReset);
  controlword_ = controlword;
  if (state_ == PowerState::kFault && rises) {
    resetting_fault_ = true;
  }
  Fall(now_ns);
  Turn(now_ns);
}

void PowerStateMachine::Fall(int64_t now_ns) {
  if (state_ != PowerState::kReadyToSwitchOn && state_ != PowerState::kSwitchedOn &&
      state_ != PowerState::kOperationEnabled && state_ != PowerState::kQuickStopActive) {
    return;
  }
  if (!Has(controlword_, kEnableVoltage)) {
    DisableVoltage();
  } else if (!Has(controlword_, kNoQuickStop)) {
    QuickStop(now_ns);
  } else if (state_ == PowerState::kQuickStopActive) {
    return;
  } else if (!Has(controlword_, kSwitchOn)) {
    Enter(PowerState::kReadyToSwitchOn);
  } else if (state_ == PowerState::kOperationEnabled && !Has(controlword_, kEnableOperation)) {
    Enter(PowerState::kSwitchedOn);
  }
}

void PowerStateMachine::DisableVoltage() {
  if (state_ != PowerState::kFault && state_ != PowerState::kNotReadyToSwitchOn) {
    Enter(PowerState::kSwitchOnDisabled);
  }
}

void PowerStateMachine::QuickStop(int64_t now_ns) {
  if (state_ == PowerState::kQuickStopActive) {
    return;
  }
  if (state_ != PowerState::kOperationEnabled || quick_stop_option_ == 0) {
    DisableVoltage();
    return;
  }
  Enter(PowerState::kQuickStopActive);
  step_ends_ns_ = now_ns + kStepNs;
}

PowerState PowerStateMachine::Next() const {
  const uint16_t rests = kEnableVoltage | kNoQuickStop;
  switch (state_) {
    case PowerState::kNotReadyToSwitchOn:
      return PowerState::kSwitchOnDisabled;
    case PowerState::kSwitchOnDisabled:
      return Has(controlword_, rests) && !Has(controlword_, kSwitchOn) ? PowerState::kReadyToSwitchOn
                                                                       : state_;
    case PowerState::kReadyToSwitchOn:
      return Has(controlword_, rests | kSwitchOn) ? PowerState::kSwitchedOn : state_;
    case PowerState::kSwitchedOn:
      return Has(controlword_, rests | kSwitchOn | kEnableOperation) ? PowerState::kOperationEnabled : state_;
    case PowerState::kQuickStopActive:
      return PowerState::kSwitchOnDisabled;
    case PowerState::kFault:
      return resetting_fault_ ? PowerState::kSwitchOnDisabled : state_;
    case PowerState::kOperationEnabled:
      break;
  }
  return state_;
}

void PowerStateMachine::Turn(int64_t now_ns) {
  if (Next() == state_) {
    step_ends_ns_ = 0;
    return;
  }
  if (step_ends_ns_ == 0) {
    step_ends_ns_ = now_ns + kStepNs;
    return;
  }
  if (now_ns >= step_ends_ns_) {
    Enter(Next());
    resetting_fault_ = false;
  }
}

void PowerStateMachine::Fail() {
  resetting_fault_ = false;
  Enter(PowerState::kFault);
}

void PowerStateMachine::Reset() {
  controlword_ = 0;
  resetting_fault_ = false;
  Enter(PowerState::kNotReadyToSwitchOn);
}

uint16_t PowerStateMachine::StatuswordBits() const {
  constexpr uint16_t kVoltageEnabled = 0x10;
  switch (state_) {
    case PowerState::kNotReadyToSwitchOn:
      return 0;
    case PowerState::kSwitchOnDisabled:
      return 0x40;
    case PowerState::kReadyToSwitchOn:
      return 0x21 | kVoltageEnabled;
    case PowerState::kSwitchedOn:
      return 0x23 | kVoltageEnabled;
    case PowerState::kOperationEnabled:
      return 0x27 | kVoltageEnabled;
    case PowerState::kQuickStopActive:
      return 0x07 | kVoltageEnabled;
    case PowerState::kFault:
      break;
  }
  return 0x08;
}

}  // namespace mwidth::device::emulator
