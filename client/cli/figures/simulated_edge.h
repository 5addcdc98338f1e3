// An edge of the M-width by numerical simulation alone.
#pragma once

#include "server/model/loop_parameters.h"

namespace mwidth::figures {

enum class Side { kPositive, kNegative };

/// Whether a push dies out in the simulated loop with virtual mass `mass`. Precondition: Validate(loop) is
/// empty.
bool PushDiesOut(const model::LoopParameters& loop, double mass);

/// The virtual mass at which simulated pushes begin to grow, to 0.1 %: walks from zero in steps of a tenth
/// until one grows, then bisects. Knows nothing of the formula it is held against. `loop` as above, with
/// damping, so that the device alone is stable. Any thread; some hundredths of a second.
double SimulatedEdge(const model::LoopParameters& loop, Side side);

}  // namespace mwidth::figures
