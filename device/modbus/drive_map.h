// Where a drive keeps what the loop needs: its holding registers.
#pragma once

#include <cstdint>
#include <optional>

#include "device/modbus/register_value.h"

namespace mwidth::device::modbus {

/// A register that lets the motor follow, or not.
struct EnableRegister {
  uint16_t address = 0;
  uint16_t enabled = 1;
  uint16_t disabled = 0;
};

/// What the drive does by itself when nobody speaks to it any more.
struct WatchdogRegisters {
  /// Time after which it reacts, s.
  RegisterValue timeout;
  /// How it reacts; `no_reaction` means that it does not.
  uint16_t reaction = 0;
  uint16_t no_reaction = 0;
};

/// All quantities in rad and N m, or m and N.
struct DriveMap {
  /// `scale` is the position of one count.
  RegisterValue position;
  /// The motor's force or torque, positive towards rising positions; `scale` is that of one count.
  RegisterValue force;
  std::optional<EnableRegister> enable;
  std::optional<WatchdogRegisters> watchdog;
};

}  // namespace mwidth::device::modbus
