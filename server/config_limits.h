// The parts of the configuration that say where rendering ends: limits, and what the watches bear.
#pragma once

#include "server/config.h"
#include "server/config_table.h"

namespace mwidth::server {

/// The table [axis.limits]. Throws ConfigError.
LimitsConfig ReadLimits(ConfigTable& limits);

/// The table [axis.watch], which may be absent. What it leaves out follows from what is known of the axis:
/// `read` needs its loop, limits and drive. Throws ConfigError.
render::WatchConfig ReadWatch(ConfigTable& axis, const AxisConfig& read);

}  // namespace mwidth::server
