// One axis under random commands and failures.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <random>

#include "server/model/estimator_kind.h"
#include "tests/server/render/axis.h"

namespace mwidth::render {

/// A filter, and what a gate would admit for it: never more is asked for.
struct AdmittedFilter {
  exchange::Filter filter;
  double min_mass = 0;
  double max_mass = 0;
};

inline constexpr std::array<AdmittedFilter, 4> kAdmittedFilters = {
    {{{static_cast<uint8_t>(model::EstimatorKind::kFilteredDifference), 10}, -0.5, 3},
     {{static_cast<uint8_t>(model::EstimatorKind::kButterworth), 20}, -0.3, 1},
     {{static_cast<uint8_t>(model::EstimatorKind::kFilteredDifference), 3}, -0.1, 0.5},
     {{static_cast<uint8_t>(model::EstimatorKind::kAccelerometer), 10}, -0.5, 2}}};

/// With an accelerometer that hardly lags.
inline device::DriveInfo SensingDrive() {
  device::DriveInfo info = ScriptedDrive().info;
  info.acceleration_quantum = 0.01;
  info.accelerometer_bandwidth_hz = 1000;
  return info;
}

/// Slow, so that a whole ramp of 0.2 s is 20 ticks, and that of a fault 5; windows of 40 ticks.
inline LoopConfig SlowConfig() {
  LoopConfig config = TestConfig();
  config.period_s = 0.01;
  config.force_slew_limit = 1000;
  config.arming_patience_s = 0.1;
  config.watch = {.window_s = 0.4,
                  .saturation_s = 0.1,
                  .slew_s = 0.1,
                  .gap_s = 0.15,
                  .late_s = 0.1,
                  .delay_limit_s = 1e-3,
                  .max_consecutive_overruns = 3,
                  .acceleration_limit = 5000,
                  .freeze_velocity = 0.1,
                  .freeze_s = 0.05};
  return config;
}

/// Commands as a gate posts them, and what cables, encoders, hosts and hands do.
class RandomAxis {
 public:
  explicit RandomAxis(uint64_t seed) : axis(SlowConfig(), SensingDrive()), random_(seed) {}

  /// The next tick's commands and failures; returns how many ticks are missed before it.
  uint64_t Disturb() {
    Command();
    DisturbDrive();
    DisturbMotion();
    loop_delay_ns = Lasts(late_ticks_, 0.003, 30) && Chance(0.7) ? 2'000'000 : 10'000;
    if (Lasts(overrun_ticks_, 0.003, 6)) {
      return 1;
    }
    return Chance(0.02) ? random_() % 8 : 0;
  }
  /// All that was broken is repaired.
  void Repair() {
    axis.drive.accepts_enable = axis.drive.answers_reads = axis.drive.takes_writes = true;
    late_ticks_ = overrun_ticks_ = intermittent_ticks_ = frozen_ticks_ = drift_ticks_ = stuck_ticks_ =
        rattle_ticks_ = 0;
    offset_ = 0;
  }

  Axis axis;
  int64_t loop_delay_ns = 0;

 private:
  bool Chance(double probability) {
    return std::uniform_real_distribution<double>(0, 1)(random_) < probability;
  }
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  // Something that begins now and then and lasts `most` ticks at most.
  bool Lasts(uint64_t& ticks, double probability, uint64_t most) {
    if (ticks > 0) {
      --ticks;
    } else if (Chance(probability)) {
      ticks = 1 + random_() % most;
    }
    return ticks > 0;
  }

  void SetAdmittedMass() {
    const AdmittedFilter& admitted = kAdmittedFilters[filter_];
    axis.settings.filter = admitted.filter;
    axis.settings.mass = Uniform(admitted.min_mass, admitted.max_mass);
  }

  void Command() {
    auto& settings = axis.settings;
    if (Chance(0.06)) {
      SetAdmittedMass();
      axis.Start(settings.mass, Chance(0.3) ? 0 : Uniform(0, 0.3));
      settings.lease_deadline_ns = axis.now_ns + (Chance(0.9) ? 600'000'000 : -1);
      axis.Post();  // The newest of several posts between two ticks wins.
    }
    if (Chance(0.05)) {
      SetAdmittedMass();
      settings.mass = Chance(0.05) ? std::numeric_limits<double>::quiet_NaN() : settings.mass;
      settings.ramp_s = Chance(0.1) ? std::numeric_limits<double>::quiet_NaN() : Uniform(0, 0.3);
      axis.Post();
    }
    if (Chance(0.02)) {
      filter_ = random_() % kAdmittedFilters.size();
      SetAdmittedMass();
      axis.Post();
    }
    if (Chance(0.05)) {
      settings.lease_deadline_ns = axis.now_ns + (Chance(0.8) ? 600'000'000 : -1);
      axis.Post();
    }
    if (Chance(0.02)) {
      settings.rendering = Chance(0.3);
      axis.Post();
    }
    if (Chance(0.005)) {
      axis.EmergencyStop();
    }
    if (Chance(0.1) && axis.status.state == exchange::State::kFault) {
      axis.ClearFault();
    }
  }

  void DisturbDrive() {
    auto& drive = axis.drive;
    drive.answers_reads = drive.answers_reads ? !Chance(0.01) : Chance(0.4);
    if (Lasts(intermittent_ticks_, 0.003, 60)) {
      drive.answers_reads = intermittent_ticks_ % 2 == 0;
    }
    drive.takes_writes = drive.takes_writes ? !Chance(0.005) : Chance(0.4);
    drive.accepts_enable = !Chance(0.15);
    drive.refusal = Chance(0.5) ? device::Enabling::kRefused : device::Enabling::kNoWatchdog;
    drive.ticks_to_enable = Chance(0.02) ? static_cast<int>(random_() % 12) : drive.ticks_to_enable;
    drive.trouble = Chance(0.002)   ? device::DriveTrouble::kError
                    : Chance(0.002) ? device::DriveTrouble::kForeignTraffic
                                    : device::DriveTrouble::kNone;
  }

  // A swing of 1 m/s and 10 m/s^2, that now and then drifts or slips out of the limits, jumps, or freezes;
  // and an accelerometer that now and then is stuck, or rattles.
  void DisturbMotion() {
    angle_ += 0.1;
    if (Lasts(drift_ticks_, 0.005, 60)) {
      offset_ += 0.03;
    } else {
      offset_ = std::max(0.0, offset_ - 0.03);
    }
    offset_ += Chance(0.002) ? 0.3 : 0;
    if (!Lasts(frozen_ticks_, 0.005, 12)) {
      const double jump = Chance(0.002) ? 1.2 : 0;
      axis.SetPosition(0.1 * std::sin(angle_) + offset_ + jump);
    }
    if (!Lasts(stuck_ticks_, 0.003, 60)) {
      axis.drive.acceleration_counts = static_cast<int32_t>(std::lround(-10 * std::sin(angle_) / 0.01));
    }
    if (Lasts(rattle_ticks_, 0.005, 30)) {
      axis.drive.acceleration_counts += rattle_ticks_ % 2 == 0 ? 1000 : -1000;
    }
  }

  std::mt19937_64 random_;
  std::size_t filter_ = 0;
  double angle_ = 0;
  double offset_ = 0;
  uint64_t late_ticks_ = 0;
  uint64_t overrun_ticks_ = 0;
  uint64_t intermittent_ticks_ = 0;
  uint64_t frozen_ticks_ = 0;
  uint64_t drift_ticks_ = 0;
  uint64_t stuck_ticks_ = 0;
  uint64_t rattle_ticks_ = 0;
};

}  // namespace mwidth::render
