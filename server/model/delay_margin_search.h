// The delay margin of a loop with an accelerometer: where its M-width loses the mass, looked for along the
// delay.
#pragma once

#include "server/model/loop_parameters.h"
#include "server/model/margins.h"

namespace mwidth::model {

/// The smallest extra delay after which the M-width of `loop` does not hold `mass` any more, to one part in
/// 1e12. The M-width is computed at 64 delays a tick, and at more of them towards each whole tick, where a
/// fast sensor just sees the newest force or does not; the first that has lost the mass is bisected from the
/// one before. Unlike ComputeDelayMargin it proves nothing about the delays between: a mass that leaves the
/// M-width and comes back within a 64th of a tick is not seen to leave. `mass` is inside the M-width of
/// `loop`. Precondition: Validate(loop) is empty. Any thread; some 0.5 ms.
DelayMargin SearchDelayMargin(const LoopParameters& loop, double mass);

}  // namespace mwidth::model
