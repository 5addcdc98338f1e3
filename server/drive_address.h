// Where a drive is, given outside of the configuration.
#pragma once

#include <string>

#include "server/config.h"

namespace mwidth::server {

/// Lets the drive of `axis` be at `address` instead of where the configuration has it: HOST:PORT (Modbus TCP,
/// or a socketcand gateway), a serial device (a path: Modbus RTU), or the name of a CAN interface. All else
/// of the drive stays. Throws ConfigError where the drive cannot be there.
void PlaceDrive(const std::string& address, AxisConfig& axis);

}  // namespace mwidth::server
