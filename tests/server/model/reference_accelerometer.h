// A held mass with an accelerometer on it, sampled, by the exponential of its states in 50 digits.
#pragma once

#include <array>
#include <boost/math/constants/constants.hpp>
#include <cstddef>
#include <vector>

#include "server/model/loop_parameters.h"
#include "tests/server/model/reference_estimator.h"
#include "tests/server/model/reference_plant.h"

namespace mwidth::model {

/// Force to what the sensor tells at the tick, in powers of z: numerator / (denominator z^(1 + delay_ticks)).
struct ReferenceAcceleration {
  RealPolynomial numerator;
  RealPolynomial denominator;
  int delay_ticks;
};

/// As Faddeev and LeVerrier have the last row of adj(z - A) and the determinant. A released hand's position,
/// and without friction the velocity too, which the sensor does not see, are left out.
inline ReferenceAcceleration AccelerationIn50Digits(const LoopParameters& loop) {
  // Position, velocity, force and sensor: the states of Generator, the sensor in the place of the hand.
  constexpr std::size_t kForce = 2;
  constexpr std::size_t kSensor = 3;
  Matrix generator = Generator(loop);
  for (auto& row : generator) {
    row[3] = row[4] = 0;
  }
  const Real rate = 2 * boost::math::constants::pi<Real>() * loop.accelerometer_bandwidth_hz;
  for (std::size_t i = 0; i < kSensor; ++i) {
    generator[kSensor][i] = -rate * generator[1][i];  // the force counts against the position
  }
  generator[kSensor][kSensor] = -rate;
  generator[kSensor][0] *= -1;
  generator[kSensor][1] *= -1;
  generator[1][kForce] *= -1;

  const Real ticks = Real(loop.delay_s) / loop.period_s;
  const Real fraction = ticks - floor(ticks);
  const Matrix a = Exponential(generator, loop.period_s);
  const Matrix late = Exponential(generator, (1 - fraction) * loop.period_s);
  std::vector<std::size_t> states{0, 1, kSensor};
  if (loop.hand_stiffness == 0) {
    states.erase(states.begin());
    if (loop.device_damping == 0 && loop.hand_damping == 0) {
      states.erase(states.begin());
    }
  }
  const std::size_t n = states.size();
  using Square = std::vector<std::vector<Real>>;
  Square adjugate(n, std::vector<Real>(n, 0));
  for (std::size_t i = 0; i < n; ++i) {
    adjugate[i][i] = 1;
  }
  ReferenceAcceleration result{.numerator = RealPolynomial(n + 1, 0),
                               .denominator = RealPolynomial(n + 1, 0),
                               .delay_ticks = static_cast<int>(floor(ticks))};
  result.denominator[n] = 1;
  for (std::size_t k = 1; k <= n; ++k) {
    for (std::size_t i = 0; i < n; ++i) {
      const Real newest = late[states[i]][kForce];
      result.numerator[n + 1 - k] += adjugate[n - 1][i] * newest;
      result.numerator[n - k] += adjugate[n - 1][i] * (a[states[i]][kForce] - newest);
    }
    Square product(n, std::vector<Real>(n, 0));
    Real trace = 0;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) {
        for (std::size_t m = 0; m < n; ++m) {
          product[i][j] += a[states[i]][states[m]] * adjugate[m][j];
        }
      }
      trace += product[i][i];
    }
    const Real coefficient = -trace / static_cast<int>(k);
    result.denominator[n - k] = coefficient;
    for (std::size_t i = 0; i < n; ++i) {
      product[i][i] += coefficient;
    }
    adjugate = product;
  }
  return result;
}

}  // namespace mwidth::model
