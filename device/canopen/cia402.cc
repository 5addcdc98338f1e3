#include "device/canopen/cia402.h"

namespace mwidth::device::canopen {

DriveState StateOf(uint16_t statusword) noexcept {
  // Bit 6: switch on disabled; 5: no quick stop; 3: fault; 2, 1, 0: operation enabled, switched on, ready.
  constexpr uint16_t kWithoutQuickStop = 0x4F;
  constexpr uint16_t kWithQuickStop = 0x6F;
  switch (statusword & kWithoutQuickStop) {
    case 0x00:
      return DriveState::kNotReadyToSwitchOn;
    case 0x40:
      return DriveState::kSwitchOnDisabled;
    case 0x0F:
      return DriveState::kFaultReactionActive;
    case 0x08:
      return DriveState::kFault;
    default:
      break;
  }
  switch (statusword & kWithQuickStop) {
    case 0x21:
      return DriveState::kReadyToSwitchOn;
    case 0x23:
      return DriveState::kSwitchedOn;
    case 0x27:
      return DriveState::kOperationEnabled;
    case 0x07:
      return DriveState::kQuickStopActive;
    default:
      return DriveState::kUnknown;
  }
}

bool MakesNoForce(DriveState state) noexcept {
  switch (state) {
    case DriveState::kNotReadyToSwitchOn:
    case DriveState::kSwitchOnDisabled:
    case DriveState::kReadyToSwitchOn:
    case DriveState::kSwitchedOn:
    case DriveState::kFault:
      return true;
    case DriveState::kOperationEnabled:
    case DriveState::kQuickStopActive:
    case DriveState::kFaultReactionActive:
    case DriveState::kUnknown:
      break;
  }
  return false;
}

const char* NameOf(DriveState state) noexcept {
  switch (state) {
    case DriveState::kNotReadyToSwitchOn:
      return "not ready to switch on";
    case DriveState::kSwitchOnDisabled:
      return "switch on disabled";
    case DriveState::kReadyToSwitchOn:
      return "ready to switch on";
    case DriveState::kSwitchedOn:
      return "switched on";
    case DriveState::kOperationEnabled:
      return "operation enabled";
    case DriveState::kQuickStopActive:
      return "quick stop active";
    case DriveState::kFaultReactionActive:
      return "fault reaction active";
    case DriveState::kFault:
      return "fault";
    case DriveState::kUnknown:
      break;
  }
  return "unknown";
}

uint16_t TowardsEnabled(DriveState state, uint16_t last) noexcept {
  switch (state) {
    case DriveState::kSwitchOnDisabled:
      return kShutdown;
    case DriveState::kReadyToSwitchOn:
      return kSwitchOn;
    case DriveState::kSwitchedOn:
    case DriveState::kOperationEnabled:
      return kEnableOperation;
    case DriveState::kFault:
      return last == kFaultReset ? kDisableVoltage : kFaultReset;
    case DriveState::kNotReadyToSwitchOn:
    case DriveState::kQuickStopActive:
    case DriveState::kFaultReactionActive:
    case DriveState::kUnknown:
      break;
  }
  return kDisableVoltage;
}

}  // namespace mwidth::device::canopen
