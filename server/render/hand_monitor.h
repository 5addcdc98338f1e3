// Watches whether the hand is one that the rendered mass is certified for.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "server/render/hand_monitor_config.h"

namespace mwidth::render {

/// Ends of the band of watched oscillations, in parts of the critical frequency: softer and stiffer hands
/// than the one that the certificate found worst.
inline constexpr double kLowestCriticalShare = 0.3;
inline constexpr double kHighestCriticalShare = 3;

/// What happened since the last observation.
struct HandObservation {
  /// First difference of the position: AccelerationEstimator::velocity().
  double velocity = 0;
  /// The force that acted meanwhile (F_a, against the positive direction), and the virtual mass behind it.
  double force = 0;
  double mass = 0;
  /// Periods since the last observation, at least 1.
  uint64_t periods = 1;
};

struct HandVerdict {
  enum class Kind : uint8_t {
    kCertified,
    /// value: growth of the oscillation in one period; limit: min_growth.
    kGrowingOscillation,
    /// value: damping that would take out what the rendered force puts in; limit: max_energy_ratio of
    /// least_damping.
    kEnergyExcess,
  };
  Kind kind = Kind::kCertified;
  double value = 0;
  double limit = 0;
  /// Frequency of the motion, and the swing of the force, peak to peak.
  double frequency_hz = 0;
  double swing = 0;
};

/// Judges the motion under a negative mass, once per half-cycle of its acceleration; README.md has the
/// reasoning, the blind spots and the figures. One thread. All Rt: some 70 operations a period, some 200 more
/// at a turning point, and no loop but those over kMostHalfCycles and the periods of a gap.
class HandMonitor {
 public:
  /// The fewest and the most half-cycles that a judgement looks back over.
  static constexpr std::size_t kFewestHalfCycles = 3;
  static constexpr std::size_t kMostHalfCycles = 6;
  /// Over a longer gap, in periods, nothing is known of the motion: the monitor begins anew.
  static constexpr uint64_t kLongestGap = 17;

  /// `force_limit` is the largest force that is commanded; both are above 0.
  HandMonitor(const HandMonitorConfig& config, double period_s, double force_limit) noexcept;

  /// How the certified loop oscillates at the negative edge of its masses; 0: unknown, nothing is watched.
  /// Another one than before begins anew.
  void SetCriticalHz(double critical_hz) noexcept;
  /// Takes the next observation. After a verdict other than kCertified the monitor begins anew.
  HandVerdict Step(const HandObservation& seen) noexcept;
  /// The next observation begins anew.
  void Forget() noexcept { watching_ = false; }

 private:
  // Sums over a stretch of time: of the filtered velocity v and its first and second differences a and j (per
  // period), and of the filtered force.
  struct Moments {
    Moments& operator+=(const Moments& other) noexcept;
    // The sums of products about the means: without the constant velocity of a reach under way.
    Moments Centred() const noexcept;

    double count = 0;
    double v = 0, a = 0, j = 0, force = 0;
    double vv = 0, av = 0, aa = 0, jv = 0, ja = 0, jj = 0, force_v = 0;
  };
  struct HalfCycle {
    Moments moments;
    double swing = 0;  // of the acceleration
  };
  // Four equal real poles: no resonance of their own.
  struct LowPass {
    double Update(double input, double gain) noexcept;
    std::array<double, 4> stages{};
  };

  void Begin(double velocity) noexcept;
  void Pass(double velocity, double force) noexcept;
  // True where a half-cycle has ended.
  bool Turned(double least_turn) noexcept;
  HandVerdict Judge(double mass) const noexcept;
  HandVerdict JudgeOver(std::size_t half_cycles, const Moments& sums, double swing) const noexcept;
  bool Grows(std::size_t half_cycles, double unexplained, double growth, double swing) const noexcept;

  const HandMonitorConfig config_;
  const double period_s_;
  const double force_limit_;
  double critical_hz_ = 0;
  double gain_ = 1;
  bool watching_ = false;
  LowPass velocity_;
  LowPass force_;
  double v_ = 0;
  double a_ = 0;
  // The last turning point of a, and the extremum since.
  double turning_point_ = 0;
  double extremum_ = 0;
  bool rising_ = true;
  bool turned_before_ = false;
  Moments now_;
  // The latest first.
  std::array<HalfCycle, kMostHalfCycles> half_cycles_{};
  std::size_t half_cycle_count_ = 0;
};

}  // namespace mwidth::render
