// Examines a host: is it fit for a loop that must not be late?
#pragma once

#include <vector>

#include "server/doctor/finding.h"
#include "server/doctor/host_files.h"
#include "server/doctor/needs.h"

namespace mwidth::doctor {

/// Every property that matters, whether it is in order or not. Changes nothing. Rights are those of the
/// calling process: run it as the user, and in the container or service, that will run the server.
std::vector<Finding> Examine(const HostFiles& host, const Needs& needs);

}  // namespace mwidth::doctor
