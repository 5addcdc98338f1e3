#include "server/model/accelerometer.h"

#include <cmath>
#include <numbers>

#include "server/model/accelerometer_response.h"
#include "server/model/low_pass.h"

namespace mwidth::model {

// The state of device and sensor, x, x' and y, goes from tick to tick as AccelerometerResponse says. A force
// that begins at the tick leaves Phi, h and y(1); with a fraction r of a tick of delay the newest leaves
// those of 1 - r, the one before the rest. Put into z Y(z) = .., the constant coefficient of the numerator
// cancels to nothing, and by h' = 1 - kappa Phi - 2 alpha h the next one to what is left below: all in
// proportion to the spring.
SampledAcceleration DiscretizeAcceleration(const LoopParameters& loop, const SampledPlant& plant) noexcept {
  const double mass = loop.device_mass + loop.hand_mass;
  const double damping = (loop.device_damping + loop.hand_damping) * loop.period_s / mass;  // 2 alpha
  const double kappa = loop.hand_stiffness * loop.period_s * loop.period_s / mass;
  const double rate = 2 * std::numbers::pi * loop.accelerometer_bandwidth_hz * loop.period_s;
  const AccelerometerResponse whole = SenseAfter(1, damping, kappa, rate);

  SampledAcceleration acceleration;
  acceleration.sensor.circle = {-std::expm1(-rate), 1 + std::exp(-rate), std::exp(-rate)};
  const double y = whole.after_step;
  const double g = whole.after_ramp;
  if (plant.hold[2] == 0) {
    acceleration.rise = {y * (whole.spring_loss + kappa * plant.hold[1]) - kappa * g * whole.impulse, y, 0};
    return acceleration;
  }
  const double fraction = loop.delay_s / loop.period_s - plant.delay_ticks;
  const AccelerometerResponse newest = SenseAfter(1 - fraction, damping, kappa, rate);
  const AccelerometerResponse rest = SenseAfter(fraction, damping, kappa, rate);
  const double kept = std::exp(-damping * (1 - fraction));
  const double spring_loss = newest.spring_loss + kept * rest.spring_loss;
  const double impulse = newest.impulse + kept * rest.impulse;
  const auto& n = plant.hold;
  acceleration.rise = {
      y * (spring_loss + kappa * (n[2] - n[0])) + newest.after_step * plant.static_gap - kappa * g * impulse,
      y * newest.slope - kappa * g * newest.impulse + newest.after_step * (plant.static_gap + plant.loss),
      newest.after_step};
  return acceleration;
}

EstimatorFactors AccelerometerFactors(const LoopParameters& loop,
                                      const SampledAcceleration& acceleration) noexcept {
  EstimatorFactors factors{.gain = 1,
                           .half_rate_zero_pairs = 0,
                           .lag_ticks = 1,
                           .pole_count = 1,
                           .poles = {{acceleration.sensor}}};
  if (loop.estimator == EstimatorKind::kFilteredAccelerometer) {
    const EstimatorFactors filter = FirstOrderLowPass::Factors(loop.period_s, loop.cutoff_hz);
    factors.gain = filter.gain;
    factors.lag_ticks = 0;
    factors.pole_count = 2;
    factors.poles[1] = filter.poles[0];
  }
  return factors;
}

}  // namespace mwidth::model
