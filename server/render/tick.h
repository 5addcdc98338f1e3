// One tick of one axis, from the encoder to the motor.
#pragma once

#include <cstdint>
#include <optional>

#include "device/drive.h"
#include "server/exchange/crossing.h"
#include "server/model/estimator.h"
#include "server/render/counter.h"
#include "server/render/limits.h"
#include "server/render/loop_config.h"
#include "server/render/supervisor.h"

namespace mwidth::render {

/// Reads the drive, estimates the acceleration, applies eq. 5 and the limits, writes the drive, and posts
/// what it did. No time, thread or memory of its own but what is passed in: the same readings and settings
/// give the same samples, to the bit. In a Sample, position = position_counts * position_quantum; velocity
/// and acceleration are those of model::AccelerationEstimator over the ticks whose position is not stale,
/// with the acceleration_counts * acceleration_quantum of those ticks where that reads an accelerometer, as
/// the sample's filter, into which it changes (ChangedTo) before its first estimate; force = force_counts *
/// force_quantum, and force_counts is mass * acceleration, rounded to counts, limited in size and in its
/// step from the force that the drive last took (of those with force_taken): the force that the drive was
/// given. Its position_counts are continuous where the drive's counter wraps. From any sample on all this can
/// be computed again without those before it: position, velocity, acceleration and filter_memory are the
/// estimator's Memory(), primed where answered_tick is not 0. The loop's thread, except the constructor; all
/// but that is Rt.
class Tick {
 public:
  /// Settings that were posted before are history, taken by another loop or not: see Supervisor.
  Tick(const LoopConfig& config, device::Drive& drive, exchange::Crossing& crossing) noexcept;

  /// Runs tick number `tick`, at `now_ns`, after `missed_ticks` were skipped (so it is that many plus one
  /// above the last).
  void Run(uint64_t tick, int64_t now_ns, uint64_t missed_ticks) noexcept;

  /// After Run: what it took from the position to the force, where both were exchanged. The next tick judges
  /// it.
  void ReportLoopDelay(std::optional<int64_t> loop_delay_ns) noexcept { loop_delay_ns_ = loop_delay_ns; }

  /// From now on nothing begins, and what is rendered ramps to zero.
  void BeginStop() noexcept { supervisor_.BeginStop(); }
  bool AtRest() const noexcept { return supervisor_.AtRest(); }
  /// Disables the drive and posts that.
  void Close() noexcept;

 private:
  /// Takes the newest settings, if any; what they leave open is as configured.
  void TakeSettings() noexcept;
  /// The motion at the last answer of the drive.
  void Follow(uint64_t tick, const device::Reading& reading) noexcept;
  ForceCommand ForceAt(double mass) noexcept;
  void Command(double mass) noexcept;
  /// Changes to the filter that is set, once no mass is rendered.
  void FollowFilter() noexcept;
  void PostSample(uint64_t tick, int64_t now_ns, bool stale) noexcept;
  void PostStatus(uint64_t tick, int64_t now_ns) noexcept;

  device::Drive& drive_;
  exchange::Crossing& crossing_;
  const device::DriveInfo info_;
  const int32_t largest_force_counts_;
  const int64_t largest_step_counts_;
  const exchange::Filter configured_filter_;
  const double period_s_;
  exchange::Settings settings_;
  exchange::Filter filter_;
  model::AccelerationEstimator estimator_;
  Supervisor supervisor_;
  ForceCommand force_;
  // The last force that the drive took.
  int32_t acting_counts_ = 0;
  bool force_taken_ = false;
  Counter counter_;
  int64_t position_counts_ = 0;
  double position_ = 0;
  int32_t acceleration_counts_ = 0;
  double sensed_acceleration_ = 0;
  uint64_t answered_tick_ = 0;
  uint64_t answer_periods_ = 1;
  std::optional<int64_t> loop_delay_ns_;
  uint64_t missed_ticks_ = 0;
  uint64_t last_tick_ = 0;
  int64_t last_ns_ = 0;
};

}  // namespace mwidth::render
