// The open loop on the unit circle, straight from eqs. 3 to 5 and 10, in any arithmetic.
#pragma once

#include <boost/math/constants/constants.hpp>
#include <cmath>
#include <complex>

#include "tests/server/model/reference_sampled_plant.h"

namespace mwidth::model {

/// M C(z) G(z) z^-delay with the paper's estimator, T = long double or Real.
template <typename T>
class ReferenceOpenLoop {
 public:
  using Complex = std::complex<T>;

  explicit ReferenceOpenLoop(const LoopParameters& loop) {
    using std::exp;
    const ReferenceSampledPlant plant = DiscretizeIn50Digits(loop);
    ticks_ = plant.delay_ticks;
    a_ = static_cast<T>(exp(-2 * boost::math::constants::pi<Real>() * loop.cutoff_hz * loop.period_s));
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
    const Complex estimator = (1 - a_) * w * w / (z * (w + (1 - a_)));
    const Complex poles = w * w + (q_ + delta_) * w + q_;
    Complex value = T(mass) * gain_ * estimator * (n0_ * z * z + n1_ * z + n2_) / (z * poles);
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
  static T Size(const Complex& value) {
    using std::sqrt;
    return sqrt(value.real() * value.real() + value.imag() * value.imag());
  }

  T a_, gain_, n0_, n1_, n2_, q_, delta_;
  int ticks_ = 0;
};

}  // namespace mwidth::model
