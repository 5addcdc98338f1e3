// What a configured axis is to the gate, whether its loop runs or not.
#pragma once

#include "server/config.h"
#include "server/gate/axis_description.h"

namespace mwidth::server {

/// The configured half of the description; what the drive and the host add to it is left at its default.
gate::AxisDescription DescribeAxis(const AxisConfig& config);

}  // namespace mwidth::server
