#include "server/render/loop_config.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "server/model/estimator.h"
#include "server/render/drive_watch.h"

namespace mwidth::render {
namespace {

void Require(bool allowed, const char* field, double value, const char* what_is_allowed) {
  if (!allowed) {
    throw std::invalid_argument(std::string(field) + " is " + std::to_string(value) + ", allowed is " +
                                what_is_allowed);
  }
}

// Here and below written so that a NaN is never allowed.
void CheckLimits(const LoopConfig& c, const device::DriveInfo& drive) {
  Require(c.force_limit > 0 && std::isfinite(c.force_limit), "force_limit", c.force_limit, "above 0");
  Require(c.force_slew_limit * c.period_s >= drive.force_quantum, "force_slew_limit", c.force_slew_limit,
          "at least a force count per period");
  Require(std::isfinite(c.position_min), "position_min", c.position_min, "any number");
  Require(std::isfinite(c.position_max) && c.position_max > c.position_min, "position_max", c.position_max,
          "above position_min");
  Require(c.velocity_limit > 0 && std::isfinite(c.velocity_limit), "velocity_limit", c.velocity_limit,
          "above 0");
  Require(c.max_missed_ticks <= 16, "max_missed_ticks", c.max_missed_ticks, "0 to 16");
  Require(c.fault_ramp_s >= 0 && c.fault_ramp_s <= 0.05, "fault_ramp_s", c.fault_ramp_s, "0 to 0.05");
  Require(c.arming_patience_s >= 0 && c.arming_patience_s <= 0.9, "arming_patience_s", c.arming_patience_s,
          "0 to 0.9");
}

void CheckAccelerometer(const LoopConfig& c, const device::DriveInfo& drive) {
  const double quantum = drive.acceleration_quantum;
  const double bandwidth_hz = drive.accelerometer_bandwidth_hz;
  Require(quantum >= 0 && std::isfinite(quantum), "the drive's acceleration_quantum", quantum,
          "above 0, or 0 where it has no accelerometer");
  Require(quantum == 0 || (bandwidth_hz >= 0.1 && bandwidth_hz <= 1e6),
          "the drive's accelerometer_bandwidth_hz", bandwidth_hz, "0.1 to 1e6");
  Require(quantum > 0 || !model::IsAccelerometer(c.estimator), "the drive's acceleration_quantum", quantum,
          "above 0 for an estimator that reads an accelerometer");
}

void CheckWatch(const WatchConfig& w) {
  Require(w.window_s >= 0.1 && w.window_s <= 10, "watch.window_s", w.window_s, "0.1 to 10");
  const auto part_of_window = [&w](const char* field, double value) {
    Require(value >= 0 && value <= w.window_s, field, value, "0 to window_s");
  };
  part_of_window("watch.saturation_s", w.saturation_s);
  part_of_window("watch.slew_s", w.slew_s);
  part_of_window("watch.gap_s", w.gap_s);
  part_of_window("watch.late_s", w.late_s);
  Require(w.delay_limit_s >= 0 && w.delay_limit_s <= 0.04, "watch.delay_limit_s", w.delay_limit_s,
          "0 to 0.04");
  Require(w.max_consecutive_overruns <= 1000, "watch.max_consecutive_overruns", w.max_consecutive_overruns,
          "0 to 1000");
  Require(w.acceleration_limit > 0 && std::isfinite(w.acceleration_limit), "watch.acceleration_limit",
          w.acceleration_limit, "above 0");
  Require(w.freeze_velocity > 0 && std::isfinite(w.freeze_velocity), "watch.freeze_velocity",
          w.freeze_velocity, "above 0");
  Require(w.freeze_s >= 0.01 && w.freeze_s <= 10, "watch.freeze_s", w.freeze_s, "0.01 to 10");
}

// In the longest gap that is bridged (ticks missed, a silence that can be held, and ticks missed once more)
// at the velocity limit, the counter must move by less than half its range: else nobody knows which way it
// went.
void CheckCounter(const LoopConfig& c, const device::DriveInfo& drive) {
  Require(drive.position_bits >= 8 && drive.position_bits <= 64, "the drive's position_bits",
          drive.position_bits, "8 to 64");
  const double longest_gap = static_cast<double>(kHeldTicks) + 1 + 2.0 * c.max_missed_ticks;
  const double counts = c.velocity_limit * longest_gap * c.period_s / drive.position_quantum;
  Require(counts < std::ldexp(1, drive.position_bits - 1), "the drive's position_bits", drive.position_bits,
          "enough that at the velocity limit the counter does not turn half around within twice "
          "max_missed_ticks and three ticks more");
}

}  // namespace

bool Runs(model::EstimatorKind estimator, double period_s, double cutoff_hz,
          const device::DriveInfo& drive) noexcept {
  return model::Runs(estimator, period_s, cutoff_hz) &&
         (!model::IsAccelerometer(estimator) || drive.senses_acceleration());
}

const LoopConfig& Checked(const LoopConfig& c, const device::DriveInfo& drive) {
  Require(c.period_s >= 1e-4 && c.period_s <= 1e-2, "period_s", c.period_s, "0.0001 to 0.01");
  Require(model::Runs(c.estimator, c.period_s, c.cutoff_hz), "cutoff_hz", c.cutoff_hz,
          "what the estimator runs with: above 0, at most half the sample rate, for butterworth 0.49 of it");
  Require(drive.position_quantum > 0 && std::isfinite(drive.position_quantum), "the drive's position_quantum",
          drive.position_quantum, "above 0");
  Require(drive.force_quantum > 0 && std::isfinite(drive.force_quantum), "the drive's force_quantum",
          drive.force_quantum, "above 0");
  CheckAccelerometer(c, drive);
  CheckLimits(c, drive);
  CheckWatch(c.watch);
  CheckCounter(c, drive);
  Require(c.realtime.priority >= 0 && c.realtime.priority <= 99, "priority", c.realtime.priority, "0 to 99");
  return c;
}

}  // namespace mwidth::render
