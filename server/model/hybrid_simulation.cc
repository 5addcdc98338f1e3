#include "server/model/hybrid_simulation.h"

namespace mwidth::model {

HybridSimulation::HybridSimulation(const LoopParameters& loop) : force_(loop.delay_s / loop.period_s) {
  const double mass = loop.device_mass + loop.hand_mass;
  const double damping_rate = (loop.device_damping + loop.hand_damping) / mass;
  const double stiffness_rate = loop.hand_stiffness / mass;

  const PlantResponse whole = RespondAfter(loop.period_s, damping_rate, stiffness_rate);
  const PlantResponse late =
      RespondAfter(loop.period_s * (1 - force_.fraction()), damping_rate, stiffness_rate);

  // The hand at constant speed u = step/T pulls with b_h u + k_h u t: a step and a ramp.
  const double damping_pull = loop.hand_damping / mass / loop.period_s;
  const double stiffness_pull = stiffness_rate / loop.period_s;
  position_growth_ = {.stretch = -stiffness_rate * whole.step,
                      .velocity = whole.impulse,
                      .hand_step = damping_pull * whole.step + stiffness_pull * whole.ramp,
                      .older_force = (late.step - whole.step) / mass,
                      .newer_force = -late.step / mass,
                      .drive = whole.step / mass,
                      .drive_slope = whole.ramp / mass / loop.period_s,
                      .drive_bend = whole.parabola / mass / (loop.period_s * loop.period_s)};
  velocity_growth_ = {.stretch = -stiffness_rate * whole.impulse,
                      .velocity = -whole.velocity_loss,
                      .hand_step = damping_pull * whole.impulse + stiffness_pull * whole.step,
                      .older_force = (late.impulse - whole.impulse) / mass,
                      .newer_force = -late.impulse / mass,
                      .drive = whole.impulse / mass,
                      .drive_slope = whole.step / mass / loop.period_s,
                      .drive_bend = whole.ramp / mass / (loop.period_s * loop.period_s)};
}

void HybridSimulation::Reset(double position, double velocity, double hand_position) noexcept {
  position_ = position;
  velocity_ = velocity;
  hand_position_ = hand_position;
  force_.Reset();
}

double HybridSimulation::AdvanceUnder(double drive, double drive_middle, double drive_next) noexcept {
  const double slope = 4 * drive_middle - 3 * drive - drive_next;
  const double bend = 4 * (drive - 2 * drive_middle + drive_next);
  const auto pull = [&](const Growth& growth) {
    return growth.drive * drive + growth.drive_slope * slope + growth.drive_bend * bend;
  };
  return Step(pull(position_growth_), pull(velocity_growth_));
}

}  // namespace mwidth::model
