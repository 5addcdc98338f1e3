// What [axis.drive] says of a CiA 402 drive on CANopen.
#pragma once

#include "device/canopen/canopen_drive_config.h"
#include "server/config_table.h"
#include "server/model/loop_parameters.h"

namespace mwidth::server {

/// Reads the keys of a "canopen" drive. Throws ConfigError where the drive's objects cannot hold a value,
/// where a force up to `force_limit` is more than the drive may give, and where heartbeats, the exchange and
/// the loop's period or delay contradict each other.
device::canopen::CanopenDriveConfig ReadCanopenDrive(ConfigTable& drive, const model::LoopParameters& loop,
                                                     double force_limit);

}  // namespace mwidth::server
