// What [axis.drive] says of a Modbus drive.
#pragma once

#include "device/modbus/modbus_drive_config.h"
#include "server/config_table.h"
#include "server/model/loop_parameters.h"

namespace mwidth::server {

/// Reads the keys of a "modbus-tcp" or "modbus-rtu" drive and the tables of its registers. The quanta are
/// set, also those of whole numbers. Throws ConfigError where registers overlap or do not exist, where a
/// force up to `force_limit` does not fit into its register, and where the exchanges of a tick do not fit
/// into the loop's period or delay.
device::modbus::ModbusDriveConfig ReadModbusDrive(ConfigTable& drive, bool tcp,
                                                  const model::LoopParameters& loop, double force_limit);

}  // namespace mwidth::server
