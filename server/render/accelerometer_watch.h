// Whether an accelerometer tells the motion that the encoder shows.
#pragma once

#include <cstdint>

#include "device/drive.h"
#include "server/render/breach.h"
#include "server/render/loop_config.h"

namespace mwidth::render {

/// Sums up what the accelerometer tells, and holds it against the velocity that the encoder shows. The loop's
/// thread; all Rt.
///
/// With x' the velocity and w_a the sensor's bandwidth, y' = w_a (x'' - y) makes the integral of y the
/// velocity behind the same lag: u' = w_a (x' - u), u = x' - y/w_a. So
///
///     e = what u has changed less what y has summed up to, forgotten with the time constant freeze_s
///
/// stays near 0 however the joint moves, and does not where the sensor is stuck, has lost its sign or its
/// scale, or is biased by more than freeze_velocity / freeze_s; nor where the encoder is stuck. Nor may y
/// tell more than acceleration_limit, which the joint does not reach, and so no mean of it. Between ticks the
/// acceleration is taken to be constant, which the staircase of the force makes it, and encoder velocities to
/// be means over a tick, half a tick old, as which y is summed up too.
class AccelerometerWatch {
 public:
  /// Without an accelerometer in `drive` nothing is ever judged.
  AccelerometerWatch(const LoopConfig& config, const device::DriveInfo& drive) noexcept;

  /// An answer, `periods` (at least 1) after the answer before: the mean velocity since then, and what the
  /// accelerometer tells now.
  void Follow(double velocity, double acceleration, uint64_t periods) noexcept;
  /// Where the last acceleration is beyond the limit of the joint, or the two disagree by more than
  /// freeze_velocity, and what the counts of both explain.
  Breach Judge() const noexcept;

 private:
  /// What a gap of so many periods does: the weights of the values at its ends.
  struct Step {
    double kept = 0;
    double mean_kept = 0;
    double duration_s = 0;
  };
  Step Over(uint64_t periods) const noexcept;

  const double period_s_;
  const double rate_;
  const double memory_s_;
  const double limit_;
  const double acceleration_limit_;
  const Step one_period_;

  // How many answers are known without too long a gap: a mean velocity takes two, its change three.
  int answers_ = 0;
  double velocity_ = 0;
  double acceleration_ = 0;
  /// u.
  double lagged_ = 0;
  /// What y summed up to in the gap before.
  double gained_ = 0;
  double disagreement_ = 0;
};

}  // namespace mwidth::render
