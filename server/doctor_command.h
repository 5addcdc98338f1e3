// `mwidthd doctor`: is this host fit for the configuration's loops?
#pragma once

#include <filesystem>

#include "server/config.h"

namespace mwidth::server {

/// Prints what there is to say about the host whose files stand below `root`, as text or as JSON, and returns
/// the exit code: 0 without a problem, warnings or not, else 1.
int RunDoctor(const Config& config, const std::filesystem::path& root, bool json);

}  // namespace mwidth::server
