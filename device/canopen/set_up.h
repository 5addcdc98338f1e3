// What a drive is told before its first tick.
#pragma once

#include <cstdint>

#include "device/can/bus.h"
#include "device/canopen/canopen_drive_config.h"
#include "device/canopen/sdo_client.h"

namespace mwidth::device::canopen {

/// Takes the force away, puts the drive's communication back to its beginning, sets it up as configured, and
/// starts it; README.md has the order. Takes a few seconds at most. Throws std::runtime_error, with what to
/// do, where the drive does not answer, is another one than configured, or refuses. Not Rt.
void SetUp(can::Bus& bus, const CanopenDriveConfig& config, Now now);

/// Whether 6076h is the rated torque that is configured, as far as its thousandths and nameplates can say.
bool IsRatedTorque(uint32_t thousandths, double configured);

}  // namespace mwidth::device::canopen
