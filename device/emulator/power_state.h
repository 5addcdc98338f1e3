// The power drive system's state machine of CiA 402-2 (section 6.1, "Finite state automaton").
#pragma once

#include <cstdint>

namespace mwidth::device::emulator {

enum class PowerState : uint8_t {
  kNotReadyToSwitchOn,
  kSwitchOnDisabled,
  kReadyToSwitchOn,
  kSwitchedOn,
  kOperationEnabled,
  kQuickStopActive,
  kFault,
};

/// Follows the controlword: towards more power after a delay, as drives that charge, release and align do;
/// towards less at once. Lives in one thread.
class PowerStateMachine {
 public:
  /// What each step towards more power takes.
  static constexpr int64_t kStepNs = 3'000'000;

  /// The controlword (6040h) as it stands from now on.
  void Command(uint16_t controlword, int64_t now_ns);
  /// 605Ah at the time of a quick stop: 0 lets go of the motor at once.
  void SetQuickStopOption(int16_t option) { quick_stop_option_ = option; }
  /// Takes the steps that are due. The motor brakes by no ramp: its torque is zero at once.
  void Turn(int64_t now_ns);
  /// From any state.
  void Fail();
  /// As after power-on.
  void Reset();
  /// What "disable voltage" and "quick stop" in a controlword do.
  void DisableVoltage();
  void QuickStop(int64_t now_ns);

  PowerState state() const { return state_; }
  /// Bits 0 to 6 of the statusword (6041h), bit 4 among them.
  uint16_t StatuswordBits() const;

 private:
  /// What the controlword makes of the state, at once.
  void Fall(int64_t now_ns);
  /// Where it leads after a step; the state itself where it does not.
  PowerState Next() const;
  void Enter(PowerState state);

  PowerState state_ = PowerState::kNotReadyToSwitchOn;
  uint16_t controlword_ = 0;
  bool resetting_fault_ = false;
  int16_t quick_stop_option_ = 0;
  /// When the step under way ends; 0: none is.
  int64_t step_ends_ns_ = 0;
};

}  // namespace mwidth::device::emulator
