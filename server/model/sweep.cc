#include "server/model/sweep.h"

#include <cmath>
#include <string>

namespace mwidth::model {
namespace {

// Allowed at every period.
constexpr double kHarmlessCutoffHz = 1;

std::optional<ParameterError> CheckRange(const std::string& side, const SweepRange& range,
                                         EstimatorKind estimator) {
  if (range.parameter == SweepParameter::kAccelerometerBandwidthHz && !IsAccelerometer(estimator)) {
    return ParameterError{side + ".parameter", static_cast<double>(range.parameter),
                          "another one with an estimator that reads no accelerometer"};
  }
  if (range.count < 2 || range.count > kMaxSweepCount) {
    return ParameterError{side + ".count", static_cast<double>(range.count), "2 to 10000"};
  }
  if (!std::isfinite(range.min) || (range.logarithmic && range.min <= 0)) {
    return ParameterError{
        side + ".min", range.min,
        range.logarithmic ? "a finite number above 0, for equal ratios" : "a finite number"};
  }
  if (!std::isfinite(range.max) || range.max < range.min) {
    return ParameterError{side + ".max", range.max, "a finite number, at least " + side + ".min"};
  }
  return std::nullopt;
}

// The range of the period, where it is swept.
const SweepRange* PeriodRange(const Sweep& sweep) {
  if (sweep.x.parameter == SweepParameter::kPeriodS) {
    return &sweep.x;
  }
  return sweep.y && sweep.y->parameter == SweepParameter::kPeriodS ? &*sweep.y : nullptr;
}

std::optional<ParameterError> CheckCorner(LoopParameters corner, const SweepRange* periods) {
  if (periods == nullptr) {
    return Validate(corner);
  }
  // A short period allows the highest cut-off, a long one the longest delay.
  LoopParameters fastest = corner;
  fastest.period_s = periods->min;
  fastest.delay_s = 0;
  if (auto error = Validate(fastest)) {
    return error;
  }
  corner.period_s = periods->max;
  corner.cutoff_hz = kHarmlessCutoffHz;
  return Validate(corner);
}

}  // namespace

const char* SweepParameterName(SweepParameter parameter) {
  switch (parameter) {
    case SweepParameter::kDeviceMass:
      return "device_mass";
    case SweepParameter::kDeviceDamping:
      return "device_damping";
    case SweepParameter::kHandMass:
      return "hand_mass";
    case SweepParameter::kHandDamping:
      return "hand_damping";
    case SweepParameter::kHandStiffness:
      return "hand_stiffness";
    case SweepParameter::kPeriodS:
      return "period_s";
    case SweepParameter::kCutoffHz:
      return "cutoff_hz";
    case SweepParameter::kDelayS:
      return "delay_s";
    case SweepParameter::kAccelerometerBandwidthHz:
      return "accelerometer_bandwidth_hz";
  }
  return "";
}

double& SweptField(LoopParameters& loop, SweepParameter parameter) {
  switch (parameter) {
    case SweepParameter::kDeviceMass:
      return loop.device_mass;
    case SweepParameter::kDeviceDamping:
      return loop.device_damping;
    case SweepParameter::kHandMass:
      return loop.hand_mass;
    case SweepParameter::kHandDamping:
      return loop.hand_damping;
    case SweepParameter::kHandStiffness:
      return loop.hand_stiffness;
    case SweepParameter::kPeriodS:
      return loop.period_s;
    case SweepParameter::kCutoffHz:
      return loop.cutoff_hz;
    case SweepParameter::kAccelerometerBandwidthHz:
      return loop.accelerometer_bandwidth_hz;
    case SweepParameter::kDelayS:
      break;
  }
  return loop.delay_s;
}

double ValueAt(const SweepRange& range, uint32_t index) {
  const uint32_t last = range.count - 1;
  if (index == 0 || index == last) {
    return index == 0 ? range.min : range.max;
  }
  const double share = static_cast<double>(index) / last;
  return range.logarithmic ? range.min * std::pow(range.max / range.min, share)
                           : std::lerp(range.min, range.max, share);
}

std::optional<ParameterError> Validate(const Sweep& sweep) {
  if (auto error = CheckRange("x", sweep.x, sweep.loop.estimator)) {
    return error;
  }
  if (sweep.y) {
    if (auto error = CheckRange("y", *sweep.y, sweep.loop.estimator)) {
      return error;
    }
    if (sweep.y->parameter == sweep.x.parameter) {
      return ParameterError{"y.parameter", static_cast<double>(sweep.y->parameter), "another one than x has"};
    }
    const uint64_t points = uint64_t{sweep.x.count} * sweep.y->count;
    if (points > kMaxSweepPoints) {
      return ParameterError{"x.count times y.count", static_cast<double>(points), "at most 1000000"};
    }
  }
  const SweepRange* periods = PeriodRange(sweep);
  for (const bool x_max : {false, true}) {
    for (const bool y_max : {false, true}) {
      LoopParameters corner = sweep.loop;
      SweptField(corner, sweep.x.parameter) = x_max ? sweep.x.max : sweep.x.min;
      if (sweep.y) {
        SweptField(corner, sweep.y->parameter) = y_max ? sweep.y->max : sweep.y->min;
      }
      if (auto error = CheckCorner(corner, periods)) {
        return error;
      }
    }
  }
  return std::nullopt;
}

}  // namespace mwidth::model
