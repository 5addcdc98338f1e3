// Loops that several tests of the model's analyses look at.
#pragma once

#include <array>
#include <cmath>
#include <random>

#include "server/model/loop_parameters.h"

namespace mwidth::model {

/// Estimators from positions, and with an accelerometer.
inline constexpr std::array kAllEstimatorKinds{kEstimatorKinds[0],     kEstimatorKinds[1],
                                               kEstimatorKinds[2],     kEstimatorKinds[3],
                                               kAccelerometerKinds[0], kAccelerometerKinds[1]};

/// Table II at 1 kHz with a cut-off of 10 Hz.
inline LoopParameters TableTwo() {
  return {.device_mass = 0.07,
          .device_damping = 0.005,
          .hand_damping = 5,
          .hand_stiffness = 700,
          .period_s = 1e-3,
          .cutoff_hz = 10};
}

/// Seeded loops all over the range that the model is made for: heavy and light, stiff, slack and nearly
/// released hands, from 100 Hz to 100 kHz, with and without delay. Every one has some damping.
class RandomLoops {
 public:
  explicit RandomLoops(unsigned seed) : random_(seed) {}

  LoopParameters Next() {
    LoopParameters loop;
    loop.device_mass = LogUniform(1e-3, 1e2);
    loop.device_damping = LogUniform(1e-4, 1e1);
    loop.hand_mass = Uniform(0, 1) < 0.3 ? LogUniform(1e-3, 1) : 0;
    loop.hand_damping = LogUniform(1e-2, 3e2);
    loop.hand_stiffness = LogUniform(1, 3e4);
    loop.period_s = LogUniform(1e-5, 1e-2);
    loop.cutoff_hz = LogUniform(1, 0.48 / loop.period_s);
    const double kind = Uniform(0, 3);
    loop.accelerometer_bandwidth_hz = 0.3 / loop.period_s;
    loop.delay_s = kind < 1 ? 0 : loop.period_s * (kind < 2 ? std::floor(kind * 3 - 2) : Uniform(0, 3));
    return loop;
  }
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  double LogUniform(double low, double high) { return std::exp(Uniform(std::log(low), std::log(high))); }

 private:
  std::mt19937_64 random_;
};

}  // namespace mwidth::model
