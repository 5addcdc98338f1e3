// The held mass as an accelerometer of its own bandwidth tells it to the sampled loop (Gil, Rubio and Savall,
// "Decreasing the Apparent Inertia of an Impedance Haptic Device by Using Force Feedforward", IEEE
// Transactions on Control Systems Technology 17, 2009).
//
//   force -> zero-order hold -> s^2/(mu s^2 + beta s + k) -> w_a/(s + w_a) -> sampled -> [H(z)] -> M -> force
//
// What is sampled is no C(z) of the sampled position: the sensor sees the motion between the ticks. It is a
// plant of third order of its own, with the poles of plant.h and one more. With y(t) the step response of the
// sensor's output, and symbols of plant.h, its sampled transfer function is, delay included and exact,
//
//   A(z) = w N(w) / (mu z^(delay_ticks + [1]) (w + f_a) (w^2 + (q + delta) w + q))      w = z - 1
//   N(w) = rise[0] + rise[1] w + rise[2] w^2          f_a = 1 - e^(-w_a T)
//
// where [1] and rise[2] are there with a fraction of a tick of delay only. Of the two zeros of s^2 one stays
// at z = 1; the other, sampled, lies near it, and at it where the hand is released: then rise[0] is 0, w
// cancels the plant's pole at z = 1, and nothing is left there to cancel numerically.
#pragma once

#include <array>

#include "server/model/estimator_factors.h"
#include "server/model/loop_parameters.h"
#include "server/model/plant.h"

namespace mwidth::model {

/// Actuator force to sampled acceleration; what it has beyond SampledPlant.
struct SampledAcceleration {
  /// Numerator N by powers of w; rise[0] is exactly 0 where the hand is released.
  std::array<double, 3> rise{};
  /// w + f_a.
  PoleFactor sensor;
};

/// Discretize of plant.h is `plant`. rise[0] counts relative to rise[1] times the size of the plant's slowest
/// pole's w: to that, all are good to some 1e-14. Precondition: Validate(loop) is empty and
/// IsAccelerometer(loop.estimator). Any thread. Rt.
SampledAcceleration DiscretizeAcceleration(const LoopParameters& loop, const SampledPlant& plant) noexcept;

/// The sensor and the digital filter behind it as factors of crossing.h: poles w + f_a and, for
/// kFilteredAccelerometer, w + f of eq. 4. Precondition as above. Any thread. Rt.
EstimatorFactors AccelerometerFactors(const LoopParameters& loop,
                                      const SampledAcceleration& acceleration) noexcept;

}  // namespace mwidth::model
