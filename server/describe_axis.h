// What a configured axis is to the gate, whether its loop runs or not.
#pragma once

#include <string>

#include "server/config.h"
#include "server/gate/axis_description.h"
#include "server/render/realtime.h"

namespace mwidth::server {

/// The configured half of the description; what the drive and the host add to it is left at its default.
gate::AxisDescription DescribeAxis(const AxisConfig& config);

/// Why an axis must not render: a real drive, and a host that refuses what its loop needs to be on time.
/// Empty where it may: on a simulated drive, on a host that granted all, or where the operator allows it.
std::string RenderingBlockedReason(bool simulated, const render::RealtimeReport& realtime,
                                   bool allow_non_realtime);

}  // namespace mwidth::server
