// Where a motion may be while a mass is rendered.
#pragma once

#include <cmath>

#include "server/render/breach.h"
#include "server/render/loop_config.h"
#include "server/render/observation.h"

namespace mwidth::render {

/// A motion that is no number. Rt.
inline Breach JudgeFinite(const Observation& seen) noexcept {
  for (const double value : {seen.position, seen.velocity, seen.acceleration}) {
    if (!std::isfinite(value)) {
      return {exchange::Fault::kNotFinite, value, 0};
    }
  }
  return {};
}

/// A finite motion outside the limits of position or velocity. Rt.
inline Breach JudgeLimits(const Observation& seen, const LoopConfig& config) noexcept {
  if (seen.position < config.position_min) {
    return {exchange::Fault::kPositionLimit, seen.position, config.position_min};
  }
  if (seen.position > config.position_max) {
    return {exchange::Fault::kPositionLimit, seen.position, config.position_max};
  }
  if (std::abs(seen.velocity) > config.velocity_limit) {
    return {exchange::Fault::kVelocityLimit, seen.velocity, config.velocity_limit};
  }
  return {};
}

}  // namespace mwidth::render
