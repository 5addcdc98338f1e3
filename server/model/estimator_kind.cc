#include "server/model/estimator_kind.h"

#include <algorithm>
#include <limits>

namespace mwidth::model {

const char* Name(EstimatorKind kind) noexcept {
  switch (kind) {
    case EstimatorKind::kFilteredDifference:
      return "filtered-difference";
    case EstimatorKind::kLateFilteredDifference:
      return "late-filtered-difference";
    case EstimatorKind::kButterworth:
      return "butterworth";
    case EstimatorKind::kKalman:
      return "kalman";
    case EstimatorKind::kAccelerometer:
      return "accelerometer";
    case EstimatorKind::kFilteredAccelerometer:
      return "filtered-accelerometer";
  }
  return "unknown";
}

std::optional<EstimatorKind> EstimatorNamed(std::string_view name) noexcept {
  for (const EstimatorKind kind : kEstimatorKinds) {
    if (name == Name(kind)) {
      return kind;
    }
  }
  for (const EstimatorKind kind : kAccelerometerKinds) {
    if (name == Name(kind)) {
      return kind;
    }
  }
  return std::nullopt;
}

CutoffRange CutoffRangeOf(EstimatorKind kind) noexcept {
  switch (kind) {
    case EstimatorKind::kButterworth:
      return {1e-9, 0.49};
    case EstimatorKind::kKalman:
      return {1e-9, 0.5};
    default:
      return {0, 0.5};
  }
}

bool Contains(const CutoffRange& range, double period_s, double cutoff_hz) noexcept {
  // 0.5/period is itself rounded; a caller who computes it may round the other way.
  constexpr double kRounding = 1 + 4 * std::numeric_limits<double>::epsilon();
  return cutoff_hz > 0 && cutoff_hz >= range.min / period_s / kRounding &&
         cutoff_hz <= range.max / period_s * kRounding;
}

bool Runs(EstimatorKind kind, double period_s, double cutoff_hz) noexcept {
  const bool known = IsAccelerometer(kind) ||
                     std::find(kEstimatorKinds.begin(), kEstimatorKinds.end(), kind) != kEstimatorKinds.end();
  return known && Contains(CutoffRangeOf(kind), period_s, cutoff_hz);
}

}  // namespace mwidth::model
