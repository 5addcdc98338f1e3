// Another filter asked for and granted, and its refusals.
#pragma once

#include <cstdint>

#include "server/exchange/crossing.h"
#include "server/gate/axis_description.h"
#include "server/gate/refusal.h"
#include "server/gate/stability_report.h"
#include "server/model/estimator_kind.h"
#include "server/model/loop_parameters.h"

namespace mwidth::gate {

/// An estimator of acceleration asked for.
struct FilterRequest {
  model::EstimatorKind estimator = model::EstimatorKind::kFilteredDifference;
  double cutoff_hz = 0;
  /// Judge only; change nothing.
  bool validate_only = false;
};

/// An estimator granted.
struct FilterGrant {
  /// The loop with it.
  model::LoopParameters loop;
  /// Judgement of the mass that is set, 0 where there is none, in that loop; its range is that of every mass
  /// from now on.
  StabilityReport stability;
  /// A tick by which the loop ran it; 0 with validate_only.
  uint64_t tick = 0;
};

/// How the loop is told of the filter of `loop`.
exchange::Filter FilterOf(const model::LoopParameters& loop);

/// FAILED_PRECONDITION (UNSTABLE_MASS, NOISY_MASS): the mass of `report` is set, and not admitted with the
/// filter of its loop.
Refusal InadmissibleWithFilter(const StabilityReport& report, const AxisDescription& axis);

}  // namespace mwidth::gate
