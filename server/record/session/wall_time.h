// The time of day of a moment of a session.
#pragma once

#include <cstdint>
#include <span>

#include "server/record/session/session_info.h"

namespace mwidth::record {

/// The wall clock, ns since 1970, at a moment of the axis's clock, as it was set then. `steps` in their
/// order.
inline int64_t WallTime(const SessionInfo& info, std::span<const WallClockStep> steps, int64_t monotonic_ns) {
  int64_t offset_ns = info.start_wall_ns - info.start_monotonic_ns;
  for (const WallClockStep& step : steps) {
    if (step.monotonic_ns <= monotonic_ns) {
      offset_ns = step.offset_ns;
    }
  }
  return monotonic_ns + offset_ns;
}

}  // namespace mwidth::record
