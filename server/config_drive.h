// The [axis.drive] table: a simulated joint, or a real drive and its link.
#pragma once

#include <filesystem>
#include <optional>
#include <variant>

#include "device/canopen/canopen_drive_config.h"
#include "device/modbus/modbus_drive_config.h"
#include "server/config_table.h"
#include "server/model/loop_parameters.h"

namespace mwidth::server {

/// Where a simulated hand goes: a built-in reach, or a recording.
struct HandMotionConfig {
  /// Length of the built-in reach; rad or m.
  double amplitude = 0;
  double duration_s = 0;
  double hold_s = 0;
  /// A recording to play instead of the built-in reach; empty: none.
  std::filesystem::path file;
  /// Which reach of the recording, from 1; none: all, one after the other.
  std::optional<int> reach;
};

struct DriveConfig {
  /// Position of one count of the encoder and force of one count of the motor.
  double position_quantum = 0;
  double force_quantum = 0;
  /// Acceleration of one count of the accelerometer, and its bandwidth; 0 where there is none.
  double acceleration_quantum = 0;
  double accelerometer_bandwidth_hz = 0;
  /// What turns the joint: a simulated hand, or a motor behind a link.
  std::variant<HandMotionConfig, device::modbus::ModbusDriveConfig, device::canopen::CanopenDriveConfig>
      behind;

  bool simulated() const { return std::holds_alternative<HandMotionConfig>(behind); }
};

/// Reads the table of an axis with this loop and this limit on the force. `folder` is where relative file
/// names begin. Throws ConfigError; a map of registers that overlap, or that cannot hold what is to be
/// written, is refused.
DriveConfig ReadDrive(ConfigTable drive, const std::filesystem::path& folder,
                      const model::LoopParameters& loop, double force_limit);

}  // namespace mwidth::server
