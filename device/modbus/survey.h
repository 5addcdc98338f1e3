// Looks at a Modbus drive without touching it.
#pragma once

#include "device/modbus/modbus_drive_config.h"
#include "device/survey.h"
#include "server/model/axis_kind.h"

namespace mwidth::device::modbus {

/// Reads every register that the configuration names, and writes none: the motor stays as it is. Waits for a
/// slow drive. Throws std::runtime_error, with what to do, where the drive cannot be reached or a server
/// holds it.
SurveyReport Survey(const ModbusDriveConfig& config, model::AxisKind kind);

}  // namespace mwidth::device::modbus
