// Looks at a CiA 402 drive without touching it.
#pragma once

#include "device/can/bus.h"
#include "device/canopen/canopen_drive_config.h"
#include "device/canopen/sdo_client.h"
#include "device/survey.h"
#include "server/model/axis_kind.h"

namespace mwidth::device::canopen {

/// Reads the objects that matter by SDO, and writes none: the drive stays as it is. A server on another host
/// that renders on it would take this for foreign traffic, and stop. Throws std::runtime_error, with what to
/// do, where the bus cannot be joined or a server of this host holds the drive.
SurveyReport Survey(const CanopenDriveConfig& config, model::AxisKind kind);

/// The same on a bus that is joined.
SurveyReport SurveyOn(can::Bus& bus, const CanopenDriveConfig& config, model::AxisKind kind, Now now);

}  // namespace mwidth::device::canopen
