// How far a virtual mass is from instability: what else may be wrong with the loop before it oscillates.
//
// With L = M C(z) G(z) z^-delay at z = e^(jt), and -1 the critical point:
//
//   gain      factor by which M, and with it |L|, may grow: to the edge of the M-width (eq. 15). It may
//   shrink
//             without limit, since M = 0 and every mass on the way there are stable.
//   phase     least angle by which L may be turned, either way, where |L| = 1: the smallest |arg(-L)|
//   delay     longest extra loop delay before the M-width no longer holds the mass
//   modulus   least distance min |1 + L| of L from -1: what a change of L must reach to destabilize. 1/Ms.
//
// None comes from a grid: |L| = 1 are the roots of |top|^2 - |bottom|^2 (open_loop.h), a polynomial in
// u = 2 - 2 cos t, and min |1 + L| follows from those of |bottom|^2 - level |top + bottom|^2.
//
// A continuous delay tau would turn L by omega tau, and its margin would be the least phase margin over
// omega. That is exact for whole ticks alone: a fraction of a tick shifts the staircase of the force within
// the hold, and changes |L| as well. delay_margin.h follows the hybrid loop itself.
#pragma once

#include <cstddef>
#include <span>

#include "server/model/linear_estimator.h"
#include "server/model/loop_parameters.h"
#include "server/model/m_width.h"

namespace mwidth::model {

/// One margin, and the frequency at which it binds: where the loop oscillates when it is used up.
struct Margin {
  double value = 0;
  /// 0 where the margin is infinite or used up already.
  double critical_hz = 0;
};

/// Delay beyond the loop's own.
struct DelayMargin {
  double seconds = 0;
  /// 0 where at_least, or where the margin is infinite or used up already.
  double critical_hz = 0;
  /// True where the margin is `seconds` or longer: the supported range of 3 periods in total ends, or, hardly
  /// ever, nothing more can be proven.
  bool at_least = false;
};

/// The margins of one mass in one loop.
struct Margins {
  /// False where the mass is not strictly inside the M-width, or that is empty. Then phase, delay and modulus
  /// are 0, and the gain margin is the factor that would bring the mass to the edge: at most 1.
  bool stable = false;
  /// A factor, not decibels; infinite for a mass of 0.
  Margin gain;
  /// rad, 0 to pi; infinite where |L| is nowhere 1.
  Margin phase_rad;
  /// Infinite for a mass of 0.
  DelayMargin delay;
  /// 1 for a mass of 0. Above 1 only for a positive mass without any friction or spring.
  Margin modulus;
};

/// Margins of `mass` (finite) in the loop of `loop`.
///
/// Towards an edge of the M-width the gain margin tends to 1, delay and modulus to 0, the phase margin too
/// unless the edge is at half the sample rate, where a loop just below it may have |L| < 1 everywhere.
/// With an accelerometer the delay margin is looked for rather than proven (delay_margin_search.h).
/// Precondition: Validate(loop) is empty. Any thread; some 0.5 ms, nearly all for the delay.
Margins ComputeMargins(const LoopParameters& loop, double mass);

/// With another estimator of acceleration, whose M-width in that loop is `m_width`; loop.cutoff_hz is not
/// used. Throws std::invalid_argument as OpenLoop does. Otherwise as above.
Margins ComputeMargins(const LoopParameters& loop, const LinearEstimator& estimator, const MWidth& m_width,
                       double mass);

/// The least of each margin among several loops, and the index of the loop that has it.
struct WorstMargins {
  Margins margins;
  std::size_t gain_loop = 0;
  std::size_t phase_loop = 0;
  std::size_t delay_loop = 0;
  std::size_t modulus_loop = 0;
};

/// Worst margins of `mass` among the given `loops`, at least one: the corners of an envelope and the loops
/// that bind its robust interval, say. No proof for the loops between them. (For the gain margin there is
/// one: over an envelope it is the edge of the robust interval divided by the mass.) Throws
/// std::invalid_argument without loops. Same conditions for each of them. Any thread.
WorstMargins WorstMarginsAmong(std::span<const LoopParameters> loops, double mass);

}  // namespace mwidth::model
