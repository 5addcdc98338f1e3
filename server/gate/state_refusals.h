// Refusals that depend on what the loop is doing.
#pragma once

#include <string>

#include "server/exchange/crossing.h"
#include "server/gate/refusal.h"

namespace mwidth::gate {

/// FAILED_PRECONDITION (WRONG_STATE) with the state in the metadata.
Refusal WrongState(const exchange::LoopStatus& status, const std::string& message);

/// WRONG_STATE: the latched fault in words.
Refusal InFault(const exchange::LoopStatus& status);

/// WRONG_STATE: a stop has been asked for and its ramp goes on.
Refusal StillStopping(const exchange::LoopStatus& status);

/// UNAVAILABLE (LOOP_SILENT).
Refusal LoopSilent();

}  // namespace mwidth::gate
