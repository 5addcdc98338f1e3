#include "server/model/hybrid_simulation.h"

#include <algorithm>
#include <cmath>

namespace mwidth::model {
namespace {

// Below this product of time and rate the series gains a factor of at least 2n per term n.
constexpr double kSeriesReach = 0.5;
// (1/2)^16 / 16! is below 1e-18.
constexpr int kSeriesTerms = 16;

/// Taylor series. The coefficients of the impulse response x = sum c_n t^n / n! follow from the equation of
/// motion: c_1 = 1, c_(n+1) = -damping c_n - stiffness c_(n-1); the others are its integrals, term by term.
PlantResponse Series(double time_s, double damping_rate, double stiffness_rate) {
  PlantResponse response;
  double before = 0;
  double coefficient = 1;
  double power = time_s;  // t^n / n!
  for (int n = 1; n <= kSeriesTerms; ++n) {
    const double term = coefficient * power;
    response.impulse += term;
    response.step += term * time_s / (n + 1);
    response.ramp += term * time_s / (n + 1) * time_s / (n + 2);
    response.parabola += term * time_s / (n + 1) * time_s / (n + 2) * time_s / (n + 3);
    const double next = -damping_rate * coefficient - stiffness_rate * before;
    before = coefficient;
    coefficient = next;
    power *= time_s / (n + 1);
  }
  response.velocity_loss = damping_rate * response.impulse + stiffness_rate * response.step;
  return response;
}

/// The response after twice the time: the motion reached after the first half goes on freely, and the
/// acceleration acts again.
PlantResponse Doubled(const PlantResponse& half, double half_time_s, double damping_rate,
                      double stiffness_rate) {
  const double position_kept = 1 - stiffness_rate * half.step;
  const double velocity_kept = 1 - half.velocity_loss;
  PlantResponse whole;
  whole.impulse = half.impulse * (position_kept + velocity_kept);
  whole.step = half.step * (1 + position_kept) + half.impulse * half.impulse;
  whole.ramp = half.ramp * (1 + position_kept) + half.impulse * half.step + half_time_s * half.step;
  whole.parabola = half.parabola * (1 + position_kept) + half.impulse * half.ramp +
                   half_time_s * (half.ramp + half_time_s / 2 * half.step);
  whole.velocity_loss = damping_rate * whole.impulse + stiffness_rate * whole.step;
  return whole;
}

}  // namespace

PlantResponse RespondAfter(double time_s, double damping_rate, double stiffness_rate) {
  const double fastest_rate = std::max(damping_rate, std::sqrt(stiffness_rate));
  int doublings = 0;
  double part_s = time_s;
  while (part_s * fastest_rate > kSeriesReach) {
    part_s /= 2;
    ++doublings;
  }
  PlantResponse response = Series(part_s, damping_rate, stiffness_rate);
  for (int i = 0; i < doublings; ++i) {
    response = Doubled(response, part_s, damping_rate, stiffness_rate);
    part_s *= 2;
  }
  return response;
}

HybridSimulation::HybridSimulation(const LoopParameters& loop) {
  const double mass = loop.device_mass + loop.hand_mass;
  const double damping_rate = (loop.device_damping + loop.hand_damping) / mass;
  const double stiffness_rate = loop.hand_stiffness / mass;
  const double delay_periods = loop.delay_s / loop.period_s;
  delay_ticks_ = static_cast<std::size_t>(delay_periods);
  const double fraction = delay_periods - static_cast<double>(delay_ticks_);

  const PlantResponse whole = RespondAfter(loop.period_s, damping_rate, stiffness_rate);
  const PlantResponse late = RespondAfter(loop.period_s * (1 - fraction), damping_rate, stiffness_rate);

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
  commands_.fill(0);
}

double HybridSimulation::Over(const Growth& growth, const HandInput& hand) const noexcept {
  return growth.stretch * (position_ - hand_position_) + growth.velocity * velocity_ +
         growth.hand_step * hand.step + growth.newer_force * commands_[delay_ticks_] +
         growth.older_force * commands_[delay_ticks_ + 1] + growth.drive * hand.drive +
         growth.drive_slope * hand.drive_slope + growth.drive_bend * hand.drive_bend;
}

double HybridSimulation::Step(const HandInput& hand) noexcept {
  const double position_gain = Over(position_growth_, hand);
  const double velocity_gain = Over(velocity_growth_, hand);
  // Gains are added, not whole values multiplied: at 10 us a tick changes the position by parts in 1e12.
  position_ += position_gain;
  velocity_ += velocity_gain;
  std::copy_backward(commands_.begin(), commands_.end() - 1, commands_.end());
  return position_;
}

double HybridSimulation::Advance(double hand_position_next) noexcept {
  const double position = Step({.step = hand_position_next - hand_position_});
  hand_position_ = hand_position_next;
  return position;
}

double HybridSimulation::AdvanceUnder(double drive, double drive_middle, double drive_next) noexcept {
  return Step({.drive = drive,
               .drive_slope = 4 * drive_middle - 3 * drive - drive_next,
               .drive_bend = 4 * (drive - 2 * drive_middle + drive_next)});
}

}  // namespace mwidth::model
