// The state machine of a drive (CiA 402-2, power drive system): what its statusword says, and which
// controlword leads on.
#pragma once

#include <cstdint>

namespace mwidth::device::canopen {

enum class DriveState : uint8_t {
  kNotReadyToSwitchOn,
  kSwitchOnDisabled,
  kReadyToSwitchOn,
  kSwitchedOn,
  kOperationEnabled,
  kQuickStopActive,
  kFaultReactionActive,
  kFault,
  /// Bits that the profile does not know.
  kUnknown,
};

/// The state in 6041h. Rt.
DriveState StateOf(uint16_t statusword) noexcept;
/// "switch on disabled".
const char* NameOf(DriveState state) noexcept;

/// The motor is let go of: nothing drives or brakes it. Rt.
bool MakesNoForce(DriveState state) noexcept;

/// Values of 6040h. A force acts only with kEnableOperation; kDisableVoltage lets go of the motor, from any
/// state.
inline constexpr uint16_t kDisableVoltage = 0x00;
inline constexpr uint16_t kShutdown = 0x06;
inline constexpr uint16_t kSwitchOn = 0x07;
inline constexpr uint16_t kEnableOperation = 0x0F;
/// Acts on its rising edge.
inline constexpr uint16_t kFaultReset = 0x80;

/// The controlword that leads from `state` one step towards "operation enabled", where `last` was the one
/// before. A fault is reset on the way. Rt.
uint16_t TowardsEnabled(DriveState state, uint16_t last) noexcept;

}  // namespace mwidth::device::canopen
