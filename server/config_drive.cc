#include "server/config_drive.h"

#include <cmath>
#include <sstream>
#include <string>

#include "server/config_canopen.h"
#include "server/config_modbus.h"

namespace mwidth::server {
namespace {

constexpr double kLargest = 1e6;

HandMotionConfig ReadHandMotion(ConfigTable motion, const std::filesystem::path& folder) {
  HandMotionConfig read{
      .amplitude = motion.Number("amplitude", {-kLargest, kLargest}),
      .duration_s = motion.NumberOr("duration_s", {0.05, 60}, 0.8),
      .hold_s = motion.NumberOr("hold_s", {0, 60}, 1.2),
      .file = motion.StringOr("file", ""),
      .reach = motion.OptionalInteger("reach", {1, kLargest}),
  };
  if (!read.file.empty()) {
    read.file = folder / read.file;
  }
  motion.Finish();
  return read;
}

DriveConfig ReadSimulated(ConfigTable& drive, const std::filesystem::path& folder) {
  DriveConfig read{.position_quantum = drive.Number("position_quantum", {0, 1, true}),
                   .force_quantum = drive.Number("force_quantum", {0, 1e3, true}),
                   .behind = ReadHandMotion(drive.Table("hand_motion"), folder)};
  if (std::optional<ConfigTable> accelerometer = drive.OptionalTable("accelerometer")) {
    read.acceleration_quantum = accelerometer->Number("quantum", {0, 1e3, true});
    read.accelerometer_bandwidth_hz = accelerometer->Number("bandwidth_hz", {0.1, kLargest});
    accelerometer->Finish();
  }
  return read;
}

}  // namespace

DriveConfig ReadDrive(ConfigTable drive, const std::filesystem::path& folder,
                      const model::LoopParameters& loop, double force_limit) {
  const std::string type = drive.OneOf("type", {"simulated", "modbus-tcp", "modbus-rtu", "canopen"});
  DriveConfig read;
  if (type == "simulated") {
    read = ReadSimulated(drive, folder);
  } else if (type == "canopen") {
    const auto canopen = ReadCanopenDrive(drive, loop, force_limit);
    read = {.position_quantum = std::abs(canopen.position_scale),
            .force_quantum = canopen.ForceQuantum(),
            .behind = canopen};
  } else {
    const auto modbus = ReadModbusDrive(drive, type == "modbus-tcp", loop, force_limit);
    read = {
        .position_quantum = modbus.position_quantum, .force_quantum = modbus.force_quantum, .behind = modbus};
  }
  // A force count crosses to the drive as 32 bits.
  if (force_limit / read.force_quantum > 2e9) {
    drive.Refuse("type", "counts its force too finely: limits.force must be at most 2e9 counts");
  }
  drive.Finish();
  return read;
}

}  // namespace mwidth::server
