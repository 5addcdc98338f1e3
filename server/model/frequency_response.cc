#include "server/model/frequency_response.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "server/model/continuous_loop.h"
#include "server/model/hybrid_simulation.h"

namespace mwidth::model {
namespace {

using Complex = std::complex<double>;

// z^-ticks.
Complex Delayed(Complex z, int ticks) {
  Complex power = 1;
  for (int i = 0; i < ticks; ++i) {
    power *= std::conj(z);
  }
  return power;
}

double MovingMass(const LoopParameters& loop) { return loop.device_mass + loop.hand_mass; }
double Damping(const LoopParameters& loop) { return loop.device_damping + loop.hand_damping; }

}  // namespace

SampledResponse::SampledResponse(const LoopParameters& loop)
    : SampledResponse(loop, IsAccelerometer(loop.estimator) ? AccelerometerFilter(loop) : EstimatorOf(loop)) {
  if (IsAccelerometer(loop.estimator)) {
    acceleration_ = DiscretizeAcceleration(loop, plant_);
  }
}

SampledResponse::SampledResponse(const LoopParameters& loop, LinearEstimator estimator)
    : loop_(loop), estimator_(std::move(estimator)), plant_(Discretize(loop)) {
  // The plant decides what is a fraction of a tick of delay and what is rounding.
  const double fraction = plant_.hold[2] == 0 ? 0 : loop.delay_s / loop.period_s - plant_.delay_ticks;
  const double damping_rate = Damping(loop) / MovingMass(loop);
  const double stiffness_rate = loop.hand_stiffness / MovingMass(loop);
  const double newest_s = (1 - fraction) * loop.period_s;
  newest_impulse_s_ = RespondAfter(newest_s, damping_rate, stiffness_rate).impulse;
  older_impulse_s_ = std::exp(-damping_rate * newest_s) *
                     RespondAfter(fraction * loop.period_s, damping_rate, stiffness_rate).impulse;
}

// A step of force that begins r T after a tick changes the velocity, 1 - r, 2 - r, ... ticks later, by h(1 -
// r), h(2 - r), ... over mu, h the impulse response. As h obeys the plant's recurrence, backwards too, that
// sequence is (h(1 - r) z - a0 h(-r)) z / (z^2 + a1 z + a0) with a0 = e^(-2 alpha) and h(-r) = -e^(2 alpha r)
// h(r).
SampledResponse::ForceResponse SampledResponse::ToForce(const CircleFrequency& at) const {
  const Complex z = at.z;
  // On the unit circle: plant.h.
  const Complex denominator = (plant_.static_gap - std::norm(at.w)) * z + plant_.loss * at.w;
  const Complex delay = Delayed(z, 1 + plant_.delay_ticks) / denominator;
  const Complex hold = (plant_.hold[0] * z + plant_.hold[1]) * z + plant_.hold[2];
  return {.position = plant_.gain * hold * delay,
          .velocity = at.w * (newest_impulse_s_ * z + older_impulse_s_) * delay / MovingMass(loop_)};
}

Complex SampledResponse::ToSensed(const CircleFrequency& at) const {
  const auto& n = acceleration_->rise;
  const Complex device = (plant_.static_gap - std::norm(at.w)) * at.z + plant_.loss * at.w;
  const Complex rise = (n[2] * at.w + n[1]) * at.w + n[0];
  return at.w / device * rise / (at.w + acceleration_->sensor.circle.at_c) *
         Delayed(at.z, plant_.delay_ticks + (plant_.hold[2] == 0 ? 0 : 1)) / MovingMass(loop_);
}

Complex SampledResponse::Loop(double mass, double frequency_hz) const {
  const CircleFrequency at = AtFrequency(frequency_hz, loop_.period_s);
  return mass * estimator_.Response(at) * (acceleration_ ? ToSensed(at) : ToForce(at).position);
}

HandResponse SampledResponse::ToHand(double mass, double frequency_hz, TickInstant instant) const {
  const Complex s(0, 2 * std::numbers::pi * frequency_hz);
  const CircleFrequency at = AtFrequency(frequency_hz, loop_.period_s);
  const ForceResponse to_force = ToForce(at);
  const Complex hand = loop_.hand_damping * s + loop_.hand_stiffness;
  // With the force off: X / X_h, and what it lacks of 1, which is small at low frequency.
  const Complex inertial = (MovingMass(loop_) * s + loop_.device_damping) * s;
  const Complex following = hand / (inertial + hand);
  const Complex lacking = inertial / (inertial + hand);

  const Complex rendered = mass * estimator_.Response(at);
  HandResponse response;
  Complex commanded;
  if (acceleration_) {
    // The sensor hears the hand continuously; only what comes back from the motor is sampled and held.
    const double sensor_rate = 2 * std::numbers::pi * loop_.accelerometer_bandwidth_hz;
    const Complex sensed = s * s * sensor_rate / (s + sensor_rate) * following;
    commanded = rendered * sensed / (1.0 + rendered * ToSensed(at));
    response.position = following - to_force.position * commanded;
  } else {
    response.position = following / (1.0 + rendered * to_force.position);
    commanded = rendered * response.position;
  }
  response.velocity = s * following - to_force.velocity * commanded;
  const Complex drive = hand * lacking + commanded * (loop_.hand_stiffness * to_force.position +
                                                      loop_.hand_damping * to_force.velocity);
  const bool stepped = instant == TickInstant::kAfterForceStep && plant_.hold[2] == 0;
  const Complex acting = commanded * Delayed(at.z, plant_.delay_ticks + (stepped ? 0 : 1));
  response.acceleration = (drive - loop_.device_damping * response.velocity - acting) / MovingMass(loop_);
  response.hand_force = drive - loop_.hand_mass * response.acceleration;
  return response;
}

Complex IdealStiffness(const LoopParameters& loop, double mass, double frequency_hz) {
  const double w = 2 * std::numbers::pi * frequency_hz;
  return -(loop.device_mass + mass) * w * w;
}

Complex RenderedStiffness(const LoopParameters& loop, double mass, double frequency_hz) {
  const double w = 2 * std::numbers::pi * frequency_hz;
  const Complex s(0, w);
  const Complex hand = loop.hand_damping * s + loop.hand_stiffness;
  const Complex device = (loop.device_mass * s + loop.device_damping) * s +
                         mass * ContinuousEstimator(loop, frequency_hz) * std::polar(1.0, -w * loop.delay_s);
  return hand * device / (device + loop.hand_mass * s * s + hand);
}

EffectiveRatios ComputeEffectiveRatios(const LoopParameters& loop, Complex stiffness, double frequency_hz) {
  const double w = 2 * std::numbers::pi * frequency_hz;
  EffectiveRatios ratios;
  ratios.mass = -stiffness.real() / (w * w) / loop.device_mass;
  if (Damping(loop) > 0) {
    ratios.damping = stiffness.imag() / w / Damping(loop);
  }
  return ratios;
}

}  // namespace mwidth::model
