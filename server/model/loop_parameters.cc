#include "server/model/loop_parameters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

namespace mwidth::model {
namespace {

// 0.5/period and 3 periods are themselves rounded; a caller who computes them may round the other way.
constexpr double kRounding = 1 + 4 * std::numeric_limits<double>::epsilon();

struct Range {
  const char* parameter;
  double value;
  double min;
  double max;
  const char* allowed;
};

// Written so that NaN is out of range.
bool Holds(const Range& range) { return range.value >= range.min && range.value <= range.max; }

// estimator with its numbers, for a period that is allowed.
std::optional<ParameterError> ValidateEstimator(const LoopParameters& loop) {
  const bool accelerometer = IsAccelerometer(loop.estimator);
  if (!accelerometer &&
      std::find(kEstimatorKinds.begin(), kEstimatorKinds.end(), loop.estimator) == kEstimatorKinds.end()) {
    std::string names;
    for (const EstimatorKind kind : kEstimatorKinds) {
      names += std::string(Name(kind)) + ", ";
    }
    names += std::string(Name(kAccelerometerKinds[0])) + ", " + Name(kAccelerometerKinds[1]);
    return ParameterError{"estimator", static_cast<double>(loop.estimator), "one of " + names};
  }
  if (accelerometer && !(loop.accelerometer_bandwidth_hz >= 0.1 && loop.accelerometer_bandwidth_hz <= 1e6)) {
    return ParameterError{"accelerometer_bandwidth_hz", loop.accelerometer_bandwidth_hz, "0.1 to 1e6"};
  }
  const CutoffRange range = CutoffRangeOf(loop.estimator);
  if (Contains(range, loop.period_s, loop.cutoff_hz)) {
    return std::nullopt;
  }
  std::string allowed =
      range.min > 0 ? "at least " + ParameterNumber(range.min / loop.period_s) + " Hz" : "above 0";
  allowed +=
      ", at most " +
      (range.max == 0.5 ? "half the sample rate" : ParameterNumber(range.max) + " of the sample rate") +
      " (" + ParameterNumber(range.max / loop.period_s) + " Hz)";
  return ParameterError{"cutoff_hz", loop.cutoff_hz, allowed};
}

}  // namespace

std::string ParameterNumber(double value) {
  std::array<char, 32> text{};
  // The shortest form that tells a value just out of range from the limit.
  if (std::snprintf(text.data(), text.size(), "%.10g", value) < 0) {
    return "?";
  }
  return text.data();
}

std::string ParameterError::Message() const {
  return parameter + " = " + ParameterNumber(value) + " is not allowed: it must be " + allowed;
}

std::optional<ParameterError> Validate(const LoopParameters& loop) {
  const std::array<Range, 6> ranges{{
      {"device_mass", loop.device_mass, 1e-6, 1e4, "1e-6 to 1e4"},
      {"device_damping", loop.device_damping, 0, 1e4, "0 to 1e4"},
      {"hand_mass", loop.hand_mass, 0, 1e4, "0 to 1e4"},
      {"hand_damping", loop.hand_damping, 0, 1e4, "0 to 1e4"},
      {"hand_stiffness", loop.hand_stiffness, 0, 1e6, "0 to 1e6"},
      {"period_s", loop.period_s, 1e-5, 1e-2, "1e-5 to 1e-2"},
  }};
  for (const Range& range : ranges) {
    if (!Holds(range)) {
      return ParameterError{range.parameter, range.value, range.allowed};
    }
  }
  if (auto error = ValidateEstimator(loop)) {
    return error;
  }
  const double delay_max_s = 3 * loop.period_s;
  if (!(loop.delay_s >= 0 && loop.delay_s <= delay_max_s * kRounding)) {
    return ParameterError{"delay_s", loop.delay_s, "0 to 3 periods (" + ParameterNumber(delay_max_s) + " s)"};
  }
  return std::nullopt;
}

}  // namespace mwidth::model
