// States and faults as people read them.
#pragma once

#include <string>

#include "server/exchange/crossing.h"

namespace mwidth::gate {

/// "IDLE", "READY", "RENDERING" or "FAULT".
std::string StateName(exchange::State state);

/// What happened and what to do: two sentences; empty for Fault::kNone.
std::string FaultMessage(const exchange::FaultRecord& fault);

}  // namespace mwidth::gate
