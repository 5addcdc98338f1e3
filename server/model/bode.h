// Bode data of a loop, and how heavy and how damped the device feels, over a range of frequencies.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/model/loop_parameters.h"

namespace mwidth::model {

/// The sampled loop that runs (frequency_response.h), or the paper's continuous approximation
/// (continuous_loop.h).
enum class ResponseModel : uint8_t { kDiscrete, kContinuous };

inline constexpr uint32_t kMaxFrequencies = 10'000;

/// `count` frequencies at equal ratios, both ends included.
struct FrequencyRange {
  double min_hz = 0.1;
  double max_hz = 100;
  uint32_t count = 200;
};

/// The first field of `range` that is not allowed at the sample period `period_s`, if any: min_hz 1e-6 to
/// 0.5/period_s; max_hz above min_hz, at most 0.5/period_s; count 2 to 10,000.
std::optional<ParameterError> Validate(const FrequencyRange& range, double period_s);

/// Columns of equal length, one entry a frequency; the effective ratios may be missing.
struct Bode {
  std::vector<double> frequency_hz;
  /// 20 lg |L|; minus infinity for a mass of 0.
  std::vector<double> magnitude_db;
  /// Phase of L in degrees, from -180 (excluded) to 180 at min_hz, and then without jumps: of two turns the
  /// nearer one. For a mass of 0, of which there is none, that of any positive mass.
  std::vector<double> phase_deg;
  /// EffectiveRatios::mass, of the ideal device 1 + M/m. Missing where the mass is not stable in this model,
  /// or where the hand holds with neither stiffness nor damping; then effective_missing says so.
  std::vector<double> effective_mass_ratio;
  /// EffectiveRatios::damping, of the ideal device 0. Missing also where nothing damps.
  std::vector<double> effective_damping_ratio;
  std::string effective_missing;
};

/// L and the effective ratios of `loop` with the virtual mass `mass`, which is finite. The continuous model
/// takes every estimator for the paper's. Precondition: Validate(loop) and Validate(range, loop.period_s) are
/// empty. Any thread; some microseconds a frequency.
Bode ComputeBode(const LoopParameters& loop, double mass, const FrequencyRange& range, ResponseModel model);

}  // namespace mwidth::model
