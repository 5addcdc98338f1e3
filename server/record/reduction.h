// How many ticks become one sample: picked, low-passed, or with their extremes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "server/exchange/crossing.h"

namespace mwidth::record {

enum class Reduction : uint8_t { kPick, kLowPass, kMinMax };

/// Least and greatest values of the ticks that one sample stands for.
struct Extremes {
  double position_min = 0;
  double position_max = 0;
  double velocity_min = 0;
  double velocity_max = 0;
  double acceleration_min = 0;
  double acceleration_max = 0;
  double force_min = 0;
  double force_max = 0;

  bool operator==(const Extremes&) const = default;
};

/// Half of a symmetric low-pass filter of 2 n - 1 taps, the middle one first, whose sum (both halves) is 1: a
/// sinc in a Kaiser window (Kaiser 1974). Over frequencies f of the input's rate 1, with the new Nyquist
/// frequency f_n = 0.5 / decimation, it is flat to 0.001 dB up to 0.8 f_n and lies below -80 dB from f_n on.
/// n is about 25.4 * decimation. A decimation of 1 leaves nothing out: one tap.
std::vector<double> LowPassTaps(uint32_t decimation);

/// Low-pass filter and decimation in one: only samples that leave are computed, each a sum over the ticks
/// around its own, 51 * decimation of them. It keeps partial sums, not ticks: 52 samples at any decimation,
/// besides the taps. Pure.
class DecimatingFilter {
 public:
  /// `decimation` is above 0.
  explicit DecimatingFilter(uint32_t decimation);

  /// Takes the sample of the next tick. Every so often returns the sample of an earlier one, a multiple of
  /// the decimation: position, velocity, acceleration, force and mass filtered, the rest as it was then. Only
  /// those return whose every tick under the filter was there.
  std::optional<exchange::Sample> Push(const exchange::Sample& sample);
  /// The next tick does not follow: begin anew.
  void Reset() { pending_.clear(); }

 private:
  /// A sample whose filter has begun to cover the ticks.
  struct Pending {
    uint64_t tick = 0;
    exchange::Sample sample;
    double position = 0;
    double velocity = 0;
    double acceleration = 0;
    double force = 0;
    double mass = 0;
  };

  const uint32_t decimation_;
  const std::vector<double> taps_;
  // taps_.size() - 1: how far the filter reaches to each side.
  const uint64_t reach_;
  std::deque<Pending> pending_;
};

struct ReducedSample {
  exchange::Sample sample;
  /// Of Reduction::kMinMax alone.
  Extremes extremes;
};

/// Makes one sample of `decimation` ticks, for the ticks that are multiples of it. Pure: one thread at a
/// time.
class Reducer {
 public:
  /// `decimation` is above 0.
  Reducer(Reduction reduction, uint32_t decimation);

  /// Takes the sample of the next tick; sometimes returns a reduced one.
  std::optional<ReducedSample> Push(const exchange::Sample& sample);
  /// The next tick does not follow the last one: nothing of what was goes into what follows.
  void Reset();

 private:
  void Widen(const exchange::Sample& sample);

  const Reduction reduction_;
  const uint32_t decimation_;
  std::optional<DecimatingFilter> filter_;
  // Since the last sample that left; none where nothing came since.
  std::optional<Extremes> extremes_;
};

}  // namespace mwidth::record
