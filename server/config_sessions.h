// [server.sessions]: where sessions are recorded.
#pragma once

#include "server/config.h"
#include "server/config_table.h"

namespace mwidth::server {

/// The table, or its defaults where there is none. Throws ConfigError.
SessionsConfig ReadSessions(ConfigTable& server);

}  // namespace mwidth::server
