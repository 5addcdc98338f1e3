// The poles of a rendering loop: oracles that know nothing of crossings.
#pragma once

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <complex>
#include <cstddef>
#include <numbers>
#include <vector>

#include "tests/server/model/reference_accelerometer.h"
#include "tests/server/model/reference_estimator.h"
#include "tests/server/model/reference_sampled_plant.h"

namespace mwidth::model {

/// The characteristic polynomial of one loop, for any virtual mass.
class ClosedLoop {
 public:
  explicit ClosedLoop(const LoopParameters& loop) {
    if (IsAccelerometer(loop.estimator)) {
      const ReferenceAcceleration sensed = AccelerationIn50Digits(loop);
      const ReferenceEstimator filter = EstimatorIn50Digits(loop);
      open_ = Times(Times(Delay(sensed.delay_ticks), filter.denominator), sensed.denominator);
      feedback_ = Times(filter.numerator, sensed.numerator);
      return;
    }
    const ReferenceSampledPlant plant = DiscretizeIn50Digits(loop);
    const ReferenceEstimator estimator = EstimatorIn50Digits(loop);
    // Poles at z = 1, which the double difference cancels, are left out: one of a released hand, both of a
    // released mass without friction.
    RealPolynomial poles{1 - plant.loss, plant.static_gap + plant.loss - 2, 1};
    RealPolynomial difference{1, -2, 1};
    if (loop.hand_stiffness == 0) {
      poles = {plant.loss - 1, 1};
      difference = {-1, 1};
      if (loop.device_damping == 0 && loop.hand_damping == 0) {
        poles = difference = {1};
      }
    }
    open_ = Times(Times(Delay(plant.delay_ticks), estimator.denominator), poles);
    const Real gain = plant.gain / (Real(loop.period_s) * loop.period_s);
    feedback_ = Times(Times({gain}, estimator.numerator),
                      Times(difference, {plant.hold[2], plant.hold[1], plant.hold[0]}));
  }

  /// Numerator of 1 + M C(z) G(z) z^-delay in powers of z (eqs. 3 to 5, 10).
  RealPolynomial Characteristic(const Real& virtual_mass) const {
    RealPolynomial sum = open_;
    for (std::size_t i = 0; i < feedback_.size(); ++i) {
      sum[i] += virtual_mass * feedback_[i];
    }
    return sum;
  }

 private:
  // The hold's tick and the whole ones of delay.
  static RealPolynomial Delay(int delay_ticks) {
    RealPolynomial delay(static_cast<std::size_t>(delay_ticks) + 2, 0);
    delay.back() = 1;
    return delay;
  }

  RealPolynomial open_;
  RealPolynomial feedback_;
};

/// Jury's criterion, as the step-down recursion of the reflection coefficients: true when every root is
/// inside the unit circle.
inline bool IsStableByJury(RealPolynomial polynomial) {
  while (polynomial.size() > 1) {
    const Real reflection = polynomial.front() / polynomial.back();
    if (abs(reflection) >= 1) {
      return false;
    }
    RealPolynomial next;
    for (std::size_t i = 1; i < polynomial.size(); ++i) {
      next.push_back(polynomial[i] - reflection * polynomial[polynomial.size() - 1 - i]);
    }
    polynomial = next;
  }
  return true;
}

/// Largest magnitude of a root, by the eigenvalues of the companion matrix in double precision.
inline double SpectralRadius(const RealPolynomial& polynomial) {
  const auto degree = static_cast<Eigen::Index>(polynomial.size()) - 1;
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(degree, degree);
  companion.diagonal(-1).setOnes();
  for (Eigen::Index i = 0; i < degree; ++i) {
    companion(i, degree - 1) =
        -static_cast<double>(polynomial[static_cast<std::size_t>(i)] / polynomial.back());
  }
  return companion.eigenvalues().cwiseAbs().maxCoeff();
}

}  // namespace mwidth::model
