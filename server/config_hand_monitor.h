// The configuration of the hand monitor.
#pragma once

#include "server/config.h"
#include "server/config_table.h"

namespace mwidth::server {

/// Reads [axis.hand_monitor], which may be left out, of an axis whose loop, envelope and tolerance have been
/// read: its least damping and inertia are those of the assumed hands and devices. Throws ConfigError.
render::HandMonitorConfig ReadHandMonitor(ConfigTable& axis, const AxisConfig& read);

}  // namespace mwidth::server
