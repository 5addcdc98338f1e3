#include "server/render/accelerometer_watch.h"

#include <cmath>
#include <numbers>

#include "server/model/estimator.h"

namespace mwidth::render {

AccelerometerWatch::AccelerometerWatch(const LoopConfig& config, const device::DriveInfo& drive) noexcept
    : period_s_(config.period_s),
      rate_(2 * std::numbers::pi * drive.accelerometer_bandwidth_hz),
      memory_s_(config.watch.freeze_s),
      // Rounding: of the position at both ends of a gap, and of every acceleration the same way.
      limit_(config.watch.freeze_velocity + drive.position_quantum / config.period_s +
             0.5 * drive.acceleration_quantum * config.watch.freeze_s),
      acceleration_limit_(config.watch.acceleration_limit),
      one_period_(drive.senses_acceleration() ? Over(1) : Step{}) {}

AccelerometerWatch::Step AccelerometerWatch::Over(uint64_t periods) const noexcept {
  const double duration_s = static_cast<double>(periods) * period_s_;
  const double decay = rate_ * duration_s;
  return {.kept = std::exp(-decay), .mean_kept = -std::expm1(-decay) / decay, .duration_s = duration_s};
}

void AccelerometerWatch::Follow(double velocity, double acceleration, uint64_t periods) noexcept {
  if (rate_ == 0) {
    return;
  }
  if (periods > model::AccelerationEstimator::kMaxBridgedPeriods) {
    answers_ = 0;  // As the estimator, which begins anew.
  }
  if (answers_ < 2) {
    lagged_ = velocity - acceleration / rate_;
    gained_ = disagreement_ = 0;
    ++answers_;
  } else {
    const Step step = periods == 1 ? one_period_ : Over(periods);
    // The acceleration that, constant over the gap, takes the sensor from its last value to this one.
    const double constant = (acceleration - step.kept * acceleration_) / (1 - step.kept);
    const double gained = step.duration_s * (constant + (acceleration_ - constant) * step.mean_kept);
    const double lagged =
        step.kept * lagged_ + (step.mean_kept - step.kept) * velocity_ + (1 - step.mean_kept) * velocity;
    disagreement_ = disagreement_ * std::exp(-step.duration_s / memory_s_) +
                    (lagged - lagged_ - 0.5 * (gained + gained_));
    lagged_ = lagged;
    gained_ = gained;
  }
  velocity_ = velocity;
  acceleration_ = acceleration;
}

Breach AccelerometerWatch::Judge() const noexcept {
  if (std::abs(acceleration_) > acceleration_limit_) {
    return {exchange::Fault::kAccelerometer, std::abs(acceleration_), acceleration_limit_};
  }
  if (std::abs(disagreement_) > limit_) {
    return {exchange::Fault::kAccelerometer, std::abs(disagreement_), limit_};
  }
  return {};
}

}  // namespace mwidth::render
