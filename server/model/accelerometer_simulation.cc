#include "server/model/accelerometer_simulation.h"

#include <numbers>

#include "server/model/accelerometer_response.h"

namespace mwidth::model {

AccelerometerSimulation::AccelerometerSimulation(const LoopParameters& loop)
    : device_(loop), force_(loop.delay_s / loop.period_s) {
  const double mass = loop.device_mass + loop.hand_mass;
  const double damping_rate = (loop.device_damping + loop.hand_damping) / mass;
  const double stiffness_rate = loop.hand_stiffness / mass;
  const double sensor_rate = 2 * std::numbers::pi * loop.accelerometer_bandwidth_hz;
  const double period = loop.period_s;
  const AccelerometerResponse whole = SenseAfter(period, damping_rate, stiffness_rate, sensor_rate);
  const AccelerometerResponse late =
      SenseAfter(period * (1 - force_.fraction()), damping_rate, stiffness_rate, sensor_rate);
  // The hand at constant speed pulls with a step and a ramp, as in HybridSimulation.
  growth_ = {
      .kept = whole.kept,
      .stretch = -stiffness_rate * whole.after_step,
      .velocity = -damping_rate * whole.after_step - stiffness_rate * whole.after_ramp,
      .hand_step = (loop.hand_damping / mass * whole.after_step + stiffness_rate * whole.after_ramp) / period,
      .older_force = (late.after_step - whole.after_step) / mass,
      .newer_force = -late.after_step / mass,
      .drive = whole.after_step / mass,
      .drive_slope = whole.after_ramp / mass / period,
      .drive_bend = whole.after_parabola / mass / (period * period)};
}

void AccelerometerSimulation::Reset(double position, double velocity, double hand_position) noexcept {
  device_.Reset(position, velocity, hand_position);
  force_.Reset();
  sensed_ = 0;
}

void AccelerometerSimulation::Sense(double hand_pull) noexcept {
  force_.Start();
  sensed_ = growth_.kept * sensed_ + growth_.stretch * (device_.position() - device_.hand_position()) +
            growth_.velocity * device_.velocity() + hand_pull + growth_.older_force * force_.older() +
            growth_.newer_force * force_.newer();
}

double AccelerometerSimulation::Advance(double hand_position_next) noexcept {
  Sense(growth_.hand_step * (hand_position_next - device_.hand_position()));
  return device_.Advance(hand_position_next);
}

double AccelerometerSimulation::AdvanceUnder(double drive, double drive_middle, double drive_next) noexcept {
  const double slope = 4 * drive_middle - 3 * drive - drive_next;
  const double bend = 4 * (drive - 2 * drive_middle + drive_next);
  Sense(growth_.drive * drive + growth_.drive_slope * slope + growth_.drive_bend * bend);
  return device_.AdvanceUnder(drive, drive_middle, drive_next);
}

}  // namespace mwidth::model
