#include "server/model/friction_simulation.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "server/model/accelerometer_response.h"

namespace mwidth::model {
namespace {

SlidingPlant PlantOf(const LoopParameters& loop, double mass) noexcept {
  return {(loop.device_damping + loop.hand_damping) / mass, loop.hand_stiffness / mass};
}

}  // namespace

FrictionSimulation::FrictionSimulation(const LoopParameters& loop, double coulomb_friction) noexcept
    : plant_(PlantOf(loop, loop.device_mass + loop.hand_mass)),
      period_s_(loop.period_s),
      mass_(loop.device_mass + loop.hand_mass),
      hand_damping_rate_(loop.hand_damping / mass_),
      friction_(coulomb_friction / mass_),
      sensor_rate_(IsAccelerometer(loop.estimator) ? 2 * std::numbers::pi * loop.accelerometer_bandwidth_hz
                                                   : 0),
      force_(loop.delay_s / loop.period_s) {
  const double early_s = period_s_ * force_.fraction();
  const double late_s = period_s_ * (1 - force_.fraction());
  early_ = {.time_s = early_s, .response = plant_.After(early_s)};
  late_ = {.time_s = late_s, .response = plant_.After(late_s)};
}

void FrictionSimulation::Reset(double position, double velocity, double hand_position) noexcept {
  position_ = position;
  velocity_ = velocity;
  hand_position_ = hand_position;
  sensed_ = 0;
  force_.Reset();
}

void FrictionSimulation::Sense(double time_s, double acceleration, double acceleration_rate) noexcept {
  if (sensor_rate_ == 0) {
    return;
  }
  const AccelerometerResponse response =
      SenseAfter(time_s, plant_.damping_rate(), plant_.stiffness_rate(), sensor_rate_);
  sensed_ =
      response.kept * sensed_ + response.after_step * acceleration + response.after_ramp * acceleration_rate;
}

double FrictionSimulation::Pull(double force) const noexcept {
  return plant_.stiffness_rate() * (hand_position_ - position_) + hand_damping_rate_ * hand_velocity_ -
         force / mass_;
}

double FrictionSimulation::StickingTime(double pull, double time_s) const noexcept {
  const double pull_rate = plant_.stiffness_rate() * hand_velocity_;
  if (pull_rate == 0) {
    return time_s;
  }
  const double loose_s = (std::copysign(friction_, pull_rate) - pull) / pull_rate;
  return loose_s < time_s ? loose_s : time_s;
}

double FrictionSimulation::SlideOn(double direction, double sliding_pull, const Part& part) noexcept {
  const double pull_rate = plant_.stiffness_rate() * hand_velocity_;
  const Slide slide{.velocity = velocity_,
                    .acceleration = sliding_pull - plant_.damping_rate() * velocity_,
                    .pull_rate = pull_rate - plant_.stiffness_rate() * velocity_,
                    .direction = direction};
  const std::optional<double> stop = plant_.FindStop(slide, part.time_s, part.response);
  const PlantResponse response = stop ? plant_.After(*stop) : part.response;
  Sense(stop ? *stop : part.time_s, slide.acceleration, slide.pull_rate);
  position_ += response.impulse * velocity_ + response.step * sliding_pull + response.ramp * pull_rate;
  if (stop) {
    velocity_ = 0;
    MoveHand(*stop);
    return part.time_s - *stop;
  }
  velocity_ +=
      response.impulse * sliding_pull + response.step * pull_rate - response.velocity_loss * velocity_;
  MoveHand(part.time_s);
  return 0;
}

void FrictionSimulation::Pass(const Part& part, double force) noexcept {
  double stopped_from = 0;  // direction of the slide that has just ended
  for (Part rest = part; rest.time_s > 0;) {
    double pull = Pull(force);
    double direction = velocity_ == 0 ? 0 : std::copysign(1.0, velocity_);
    if (direction == 0) {
      // What stopped was not pulled on beyond friction, whatever rounding says: a slide too short to move
      // anything would begin again for ever.
      pull = stopped_from * pull > friction_ ? stopped_from * friction_ : pull;
      if (std::abs(pull) <= friction_) {
        const double sticking_s = StickingTime(pull, rest.time_s);
        Sense(sticking_s, 0, 0);
        MoveHand(sticking_s);
        rest.time_s -= sticking_s;
        // If it breaks loose, then where the hand's motion has just brought the pull up to friction.
        pull = std::copysign(friction_, hand_velocity_);
      }
      direction = std::copysign(1.0, pull);
    }
    if (rest.time_s > 0) {
      if (rest.time_s != part.time_s) {
        rest.response = plant_.After(rest.time_s);
      }
      rest.time_s = SlideOn(direction, pull - direction * friction_, rest);
      stopped_from = direction;
    }
  }
}

double FrictionSimulation::Advance(double hand_position_next) noexcept {
  force_.Start();
  hand_velocity_ = (hand_position_next - hand_position_) / period_s_;
  Pass(early_, force_.older());
  Pass(late_, force_.newer());
  hand_position_ = hand_position_next;
  return position_;
}

}  // namespace mwidth::model
