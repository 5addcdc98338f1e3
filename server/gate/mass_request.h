// A virtual mass asked for and granted, and the refusals that depend on nothing but the request and the axis.
#pragma once

#include <cstdint>
#include <optional>

#include "server/gate/axis_description.h"
#include "server/gate/mass_accuracy.h"
#include "server/gate/refusal.h"
#include "server/gate/stability_report.h"

namespace mwidth::gate {

inline constexpr double kDefaultRampS = 0.2;
inline constexpr double kMaxRampS = 10;

/// A mass asked for.
struct MassRequest {
  double mass = 0;
  /// Judge only; change nothing.
  bool validate_only = false;
  /// Time of the ramp from the present mass; 0..10 s.
  double ramp_s = kDefaultRampS;
};

/// A mass granted.
struct MassGrant {
  double mass = 0;
  StabilityReport stability;
  MassAccuracy accuracy;
  /// A tick by which the loop had taken it up; 0 with validate_only.
  uint64_t tick = 0;
};

/// INVALID_ARGUMENT where a number is not finite (INVALID_NUMBER), the ramp is out of range (INVALID_NUMBER)
/// or the mass is outside the axis's hard limits (MASS_LIMIT).
std::optional<Refusal> CheckNumbers(const MassRequest& request, const AxisDescription& axis);

/// The refusal of a mass that `report` does not admit, with `report` attached: FAILED_PRECONDITION,
/// UNSTABLE_MASS with the ranges in words, or NOISY_MASS with the noise and its limit.
Refusal InadmissibleMass(const StabilityReport& report, const AxisDescription& axis);

}  // namespace mwidth::gate
