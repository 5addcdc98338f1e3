// The open loop on the unit circle, straight from eqs. 3 to 5 and 10, in any arithmetic.
#pragma once

#include <boost/math/constants/constants.hpp>
#include <cmath>
#include <complex>
#include <cstddef>
#include <vector>

#include "tests/server/model/reference_accelerometer.h"
#include "tests/server/model/reference_estimator.h"
#include "tests/server/model/reference_sampled_plant.h"

namespace mwidth::model {

/// M C(z) G(z) z^-delay, or M H(z) A(z) with an accelerometer; T = long double or Real.
template <typename T>
class ReferenceOpenLoop {
 public:
  using Complex = std::complex<T>;

  explicit ReferenceOpenLoop(const LoopParameters& loop) {
    if (IsAccelerometer(loop.estimator)) {
      const ReferenceAcceleration sensed = AccelerationIn50Digits(loop);
      const ReferenceEstimator filter = EstimatorIn50Digits(loop);
      ticks_ = sensed.delay_ticks + 1;
      numerator_ = InDifferences(Times(filter.numerator, sensed.numerator));
      denominator_ = InDifferences(Times(filter.denominator, sensed.denominator));
      return;
    }
    const ReferenceSampledPlant plant = DiscretizeIn50Digits(loop);
    ticks_ = plant.delay_ticks;
    const ReferenceEstimator estimator = EstimatorIn50Digits(loop);
    numerator_ = InDifferences(estimator.numerator);
    denominator_ = InDifferences(estimator.denominator);
    gain_ = static_cast<T>(plant.gain / (Real(loop.period_s) * loop.period_s));
    n0_ = static_cast<T>(plant.hold[0]);
    n1_ = static_cast<T>(plant.hold[1]);
    n2_ = static_cast<T>(plant.hold[2]);
    q_ = static_cast<T>(plant.static_gap);
    delta_ = static_cast<T>(plant.loss);
  }

  /// At z = e^(j angle), angle above 0.
  Complex Value(double mass, const T& angle) const {
    using std::cos;
    using std::sin;
    const T half_sine = sin(angle / 2);
    const Complex w(-2 * half_sine * half_sine, sin(angle));
    const Complex z(cos(angle), sin(angle));
    Complex value = T(mass) * At(numerator_, w) / At(denominator_, w);
    if (gain_ != 0) {
      const Complex poles = w * w + (q_ + delta_) * w + q_;
      value *= w * w * gain_ * (n0_ * z * z + n1_ * z + n2_) / (z * poles);
    }
    for (int i = 0; i < ticks_; ++i) {
      value /= z;
    }
    return value;
  }

  /// |1 + L|, |L| and |arg(-L)|.
  T Distance(double mass, const T& angle) const { return Size(T(1) + Value(mass, angle)); }
  T Gain(double mass, const T& angle) const { return Size(Value(mass, angle)); }
  T Phase(double mass, const T& angle) const {
    using std::abs;
    using std::atan2;
    const Complex value = Value(mass, angle);
    return abs(atan2(-value.imag(), -value.real()));
  }

 private:
  // In powers of w = z - 1, which long double needs near z = 1.
  static std::vector<T> InDifferences(const RealPolynomial& polynomial) {
    RealPolynomial shifted{0};
    for (std::size_t k = polynomial.size(); k-- > 0;) {
      shifted = Times(shifted, {1, 1});
      shifted[0] += polynomial[k];
    }
    std::vector<T> result;
    for (const Real& coefficient : shifted) {
      result.push_back(static_cast<T>(coefficient));
    }
    return result;
  }
  static Complex At(const std::vector<T>& polynomial, const Complex& w) {
    Complex value(T(0), T(0));
    for (std::size_t k = polynomial.size(); k-- > 0;) {
      value = value * w + polynomial[k];
    }
    return value;
  }
  static T Size(const Complex& value) {
    using std::sqrt;
    return sqrt(value.real() * value.real() + value.imag() * value.imag());
  }

  std::vector<T> numerator_;
  std::vector<T> denominator_;
  // Of the plant behind an estimator from positions.
  T gain_ = 0;
  T n0_, n1_, n2_, q_, delta_;
  int ticks_ = 0;
};

}  // namespace mwidth::model
