// One axis under test: its drive, its crossing and its tick, with time under the test's control.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>

#include "server/exchange/crossing.h"
#include "server/render/loop_config.h"
#include "server/render/tick.h"
#include "tests/server/render/scripted_drive.h"

namespace mwidth::render {

inline LoopConfig TestConfig() {
  return {.period_s = 1e-3,
          .cutoff_hz = 10,
          .force_limit = 20,
          .position_min = -1,
          .position_max = 1,
          .velocity_limit = 5,
          .max_missed_ticks = 5,
          .fault_ramp_s = 0.05,
          .watch = {.delay_limit_s = 1e-3, .acceleration_limit = 5000, .freeze_velocity = 0.1},
          .hand_monitor = {},
          .realtime = {.priority = 0, .cpu = -1}};
}

class Axis {
 public:
  explicit Axis(const LoopConfig& loop_config = TestConfig(),
                const device::DriveInfo& info = ScriptedDrive().info)
      : config(loop_config),
        period_ns(std::llround(loop_config.period_s * 1e9)),
        tick_(config, WithInfo(drive, info), *crossing) {}

  /// Posts `settings` as the gate would.
  void Post() {
    ++settings.sequence;
    crossing->settings.Post(settings);
  }
  /// StartRendering with a lease that outlives every test.
  void Start(double mass, double ramp_s) {
    settings.rendering = true;
    ++settings.render_epoch;
    settings.mass = mass;
    settings.ramp_s = ramp_s;
    settings.lease_deadline_ns = INT64_MAX;
    Post();
  }
  void StopRendering() {
    settings.rendering = false;
    Post();
  }
  void EmergencyStop() {
    ++settings.emergency_stops;
    Post();
  }
  void ClearFault() {
    settings.cleared_fault_number = status.fault.number;
    Post();
  }
  void SetPosition(double position) {
    swinging_ = false;
    drive.position_counts = std::llround(position / drive.info.position_quantum);
  }

  /// Runs one tick after `missed` that were skipped, and takes what it posted.
  const exchange::Sample& Run(uint64_t missed = 0) {
    tick += 1 + missed;
    now_ns += static_cast<int64_t>(1 + missed) * period_ns;
    tick_.Run(tick, now_ns, missed);
    crossing->status.Take(status);
    crossing->samples.Pop(sample);
    return sample;
  }
  /// The arm goes on as it was: an arm that swings does not stop dead.
  void RunTicks(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      swinging_ ? Swing() : Run();
    }
  }
  /// Moves the arm smoothly to `position` in half a second, or until there is a fault.
  void MoveTo(double position) {
    const double from = static_cast<double>(drive.position_counts) * drive.info.position_quantum;
    for (int i = 1; i <= 500 && (i == 1 || status.state != exchange::State::kFault); ++i) {
      SetPosition(from + (position - from) * (1 - std::cos(std::numbers::pi * i / 500)) / 2);
      Run();
    }
  }
  /// Brings the axis to RENDERING with `mass` arrived and the arm swinging, so that there is a force.
  void RenderSwinging(double mass) {
    Start(mass, 0);
    for (int i = 0; i < 300; ++i) {
      Swing();
    }
  }
  /// One tick of a 2 Hz swing over 0.2 m, from rest: at most 1.3 m/s and 16 m/s^2.
  const exchange::Sample& Swing(uint64_t missed = 0) {
    SetPosition(SwingAt(tick + 1 + missed));
    if (drive.info.senses_acceleration()) {
      drive.acceleration_counts = static_cast<int32_t>(
          std::lround(SensedInSwingAt(tick + 1 + missed) / drive.info.acceleration_quantum));
    }
    swinging_ = true;
    return Run(missed);
  }
  double SwingAt(uint64_t at_tick) const {
    return 0.1 * (1 - std::cos(4 * std::numbers::pi * static_cast<double>(at_tick) * config.period_s));
  }
  /// What an accelerometer tells of it, behind its own lag.
  double SensedInSwingAt(uint64_t at_tick) const {
    const double w = 4 * std::numbers::pi;
    const double sensor_rate = 2 * std::numbers::pi * drive.info.accelerometer_bandwidth_hz;
    const double angle = w * static_cast<double>(at_tick) * config.period_s;
    const double lag = w / sensor_rate;
    return 0.1 * w * w * (std::cos(angle) + lag * std::sin(angle)) / (1 + lag * lag);
  }
  Tick& tick_under_test() { return tick_; }

  LoopConfig config;
  int64_t period_ns;
  ScriptedDrive drive;
  std::unique_ptr<exchange::Crossing> crossing = std::make_unique<exchange::Crossing>();
  exchange::Settings settings;
  exchange::LoopStatus status;
  exchange::Sample sample;
  uint64_t tick = 0;
  int64_t now_ns = 1'000'000'000;

 private:
  static device::Drive& WithInfo(ScriptedDrive& drive, const device::DriveInfo& info) {
    drive.info = info;
    return drive;
  }

  bool swinging_ = false;
  Tick tick_;
};

}  // namespace mwidth::render
