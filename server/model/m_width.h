// The M-width of a loop: which virtual masses it renders stably, in closed form.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>

#include "server/model/loop_parameters.h"

namespace mwidth::model {

/// One end of an M-width.
struct Edge {
  /// Virtual mass at which a root of 1 + M H(z) D(z) G(z) z^-delay reaches the unit circle.
  double mass = 0;
  /// Frequency of that root: how the loop oscillates there.
  double critical_hz = 0;
};

/// The open, connected interval around zero of stable virtual masses, or the reason why there is none.
struct MWidth {
  Edge lower;
  Edge upper;
  /// Not empty where not even M = 0 is asymptotically stable (both damping terms zero with a spring); then
  /// the edges mean nothing.
  std::string empty_reason;

  bool empty() const { return !empty_reason.empty(); }
  /// True when `mass` is strictly inside.
  bool Contains(double mass) const { return !empty() && lower.mass < mass && mass < upper.mass; }
};

/// M-width of the discrete (equal to the hybrid) model, eqs. 3 to 5 and 10, with loop delay.
/// Precondition: Validate(loop) is empty; a caller with unchecked input calls that first. Throws nothing and
/// allocates nothing but the reason of an empty result. Any thread.
MWidth ComputeMWidth(const LoopParameters& loop);

/// Both edges of an M-width and nothing else; NaN where it is empty.
struct EdgeMasses {
  double lower = std::numeric_limits<double>::quiet_NaN();
  double upper = std::numeric_limits<double>::quiet_NaN();

  /// True when `mass` is strictly between them.
  bool Contain(double mass) const noexcept { return lower < mass && mass < upper; }
};

/// The masses of ComputeMWidth, to the last bit, without its frequencies and its reason: for searches and
/// grids, which ask for thousands. Precondition as above. Any thread. Rt.
EdgeMasses ComputeEdgeMasses(const LoopParameters& loop) noexcept;

/// Factor by which `mass` may grow before it leaves the M-width (eq. 15): above 1 stable, below 1 unstable,
/// infinite at a mass of 0, 0 where the M-width is empty. Not in decibels.
double GainMargin(const MWidth& m_width, double mass);

/// Highest cut-off frequency at most `highest_hz` that `admits` accepts; none where it accepts none down to
/// 0.1 Hz. Relative accuracy 1e-6, from below: the answer itself is accepted. The search goes down in steps
/// of 3 %, so a narrower island of admitting cut-offs may be passed over in favour of a lower answer.
std::optional<double> HighestAdmittingCutoffHz(double highest_hz, const std::function<bool(double)>& admits);

/// The same, from `loop.cutoff_hz` down, where `mass`, grown by `gain_margin`, is inside the M-width of
/// `loop` otherwise unchanged. Precondition as above.
std::optional<double> HighestAdmittingCutoffHz(const LoopParameters& loop, double mass, double gain_margin);

}  // namespace mwidth::model
