// A grid over one or two loop parameters: what it is, and what is allowed.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "server/model/loop_parameters.h"

namespace mwidth::model {

/// A parameter that a grid may run over.
enum class SweepParameter : uint8_t {
  kDeviceMass,
  kDeviceDamping,
  kHandMass,
  kHandDamping,
  kHandStiffness,
  kPeriodS,
  kCutoffHz,
  kDelayS,
  kAccelerometerBandwidthHz,
};

inline constexpr std::array kSweepParameters{
    SweepParameter::kDeviceMass,  SweepParameter::kDeviceDamping, SweepParameter::kHandMass,
    SweepParameter::kHandDamping, SweepParameter::kHandStiffness, SweepParameter::kPeriodS,
    SweepParameter::kCutoffHz,    SweepParameter::kDelayS,        SweepParameter::kAccelerometerBandwidthHz};

/// The name of its field in LoopParameters, such as "device_mass".
const char* SweepParameterName(SweepParameter parameter);

/// The field itself.
double& SweptField(LoopParameters& loop, SweepParameter parameter);

inline constexpr uint32_t kMaxSweepCount = 10'000;
inline constexpr uint64_t kMaxSweepPoints = 1'000'000;

/// One side of a grid: `count` values from `min` to `max`, both included.
struct SweepRange {
  SweepParameter parameter = SweepParameter::kDeviceMass;
  double min = 0;
  double max = 0;
  uint32_t count = 2;
  /// Equal ratios instead of equal steps.
  bool logarithmic = false;
};

/// The value at `index`, below `range.count`; exactly min and max at the ends. Any thread.
double ValueAt(const SweepRange& range, uint32_t index);

/// A grid: `x` runs fastest; without `y` it has one row.
struct Sweep {
  /// What is not swept.
  LoopParameters loop;
  SweepRange x;
  std::optional<SweepRange> y;
};

/// The first thing that is wrong with a sweep, if any. Counts are 2 to 10,000, and 1,000,000 points in all;
/// ends are finite and in order, above 0 where logarithmic, and inside the parameter's own range; x and y
/// differ. cutoff_hz and delay_s are limited by the period: where that is swept, they are held against the
/// period of the sweep that allows the most, and points that are out of range at their own period have no
/// M-width. accelerometer_bandwidth_hz is swept with an accelerometer alone. Names the parameter, or
/// "x.count", "y.min" and the like.
std::optional<ParameterError> Validate(const Sweep& sweep);

}  // namespace mwidth::model
