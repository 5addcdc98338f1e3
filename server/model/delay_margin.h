// How much longer a loop may be delayed before a given mass leaves the M-width.
//
// Delayed by h more ticks, the staircase of the force moves by h, and for that long the mass misses each step
// of it: a pulse in every hold, which the plant's recurrence answers with two areas p and r in the numerator,
//
//   N becomes N - (1 - 1/z) (p + r/z)      |p| + |r| <= h min(1, 1/alpha, 2/sqrt(kappa))
//
// because x'' + 2 alpha x' + kappa x = 0, released at 0 with velocity 1, is never further than v at the time
// v, nor than 1/(2 alpha), nor than 1/sqrt(kappa), and each instant of the pulse has two ways to the ticks,
// of lengths that sum to 1. So L changes by less than |1 + L| all along the circle, and no root can cross it,
// as long as
//
//   h min(..) < 1/R      R = max over t of StepSize / |top + bottom|       (open_loop.h)
//
// R comes with a proof (level_set.h). From the delay so reached the next step begins: the steps become short
// in proportion to what is left, and never pass a crossing. The last stretch is Newton's.
#pragma once

#include "server/model/linear_estimator.h"
#include "server/model/loop_parameters.h"
#include "server/model/margins.h"

namespace mwidth::model {

/// The delay margin of `mass`, not 0, inside the M-width of `loop`: the smallest extra delay at which a root
/// of 1 + L reaches the circle, or at which the M-width, shrinking from inside, loses the mass. The first is
/// proven up to 1e-5 of the margin, or to where |1 + L| = 1e-6; the second, which happens where the sampling
/// is slow against hand and device, is looked for at every step and then bisected. `likely_hz` is where to
/// look first for the crossing. Where the proof gets stuck, all that it proved is a margin of at least that:
/// after 4000 steps, close to -1 without a crossing, or at damping ratios below 1e-9.
///
/// Precondition: Validate(loop) is empty. Throws std::invalid_argument as OpenLoop does. Any thread; some 25
/// us a step, of which there are 10 to 200 mostly.
DelayMargin ComputeDelayMargin(const LoopParameters& loop, const LinearEstimator& estimator, double mass,
                               double likely_hz);

}  // namespace mwidth::model
