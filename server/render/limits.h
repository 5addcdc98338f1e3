// Between numbers and counts: what is commanded and recorded is what the drive's integers can say.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace mwidth::render {

/// A position from its encoder counts; m or rad. Rt.
inline double PositionOf(int64_t counts, double position_quantum) noexcept {
  return static_cast<double>(counts) * position_quantum;
}

/// A force as the drive gets it.
struct ForceCommand {
  int32_t counts = 0;
  /// The wanted force was beyond the limit.
  bool saturated = false;
  /// So was its change since the force before.
  bool slew_limited = false;
};

/// The largest count whose force is within `force_limit` and within the drive's integers. Rt.
inline int32_t LargestForceCounts(double force_limit, double force_quantum) noexcept {
  const double largest_integer = std::numeric_limits<int32_t>::max();
  auto counts = static_cast<int32_t>(std::min(std::floor(force_limit / force_quantum), largest_integer));
  // The division rounds, and may have rounded up to the next whole number.
  while (counts > 0 && counts * force_quantum > force_limit) {
    --counts;
  }
  return counts;
}

/// `force`, which is finite, in counts to the nearest, never beyond `largest_counts` either way. Rt.
inline ForceCommand LimitForce(double force, double force_quantum, int32_t largest_counts) noexcept {
  const double wanted = std::round(force / force_quantum);
  const double largest = largest_counts;
  return {.counts = static_cast<int32_t>(std::clamp(wanted, -largest, largest)),
          .saturated = std::abs(wanted) > largest};
}

/// The largest change in counts, from one force to the next, that is within `slew_limit` (N/s or N m/s) in
/// one period; at most the full span, which is no limit. Rt.
inline int64_t LargestStepCounts(double slew_limit, double period_s, double force_quantum,
                                 int32_t largest_counts) noexcept {
  // The division may have rounded down from a whole number.
  const double step = std::floor(slew_limit * period_s / force_quantum * (1 + 1e-12));
  return static_cast<int64_t>(std::min(step, 2.0 * largest_counts));
}

/// `wanted`, but no further than `largest_step` from the force that acts, `acting_counts`. Where both are
/// within the force limit, so is what comes out. Rt.
inline ForceCommand LimitStep(const ForceCommand& wanted, int32_t acting_counts,
                              int64_t largest_step) noexcept {
  const int64_t step = int64_t{wanted.counts} - acting_counts;
  const int64_t taken = std::clamp(step, -largest_step, largest_step);
  return {.counts = static_cast<int32_t>(acting_counts + taken),
          .saturated = wanted.saturated,
          .slew_limited = taken != step};
}

}  // namespace mwidth::render
