// The estimators from their definitions, in 50 digits and more: what factors and recurrences are held
// against.
#pragma once

#include <array>
#include <boost/math/constants/constants.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cstddef>
#include <vector>

#include "server/model/loop_parameters.h"
#include "tests/server/model/reference_plant.h"

namespace mwidth::model {

/// Coefficients, the constant first.
using RealPolynomial = std::vector<Real>;

inline RealPolynomial Times(const RealPolynomial& a, const RealPolynomial& b) {
  RealPolynomial product(a.size() + b.size() - 1, 0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t k = 0; k < b.size(); ++k) {
      product[i + k] += a[i] * b[k];
    }
  }
  return product;
}

/// Gains of the steady-state Kalman filter for tracking index lambda: state position, velocity and
/// acceleration per tick, unit variance of a measurement, acceleration stepped by white noise of variance
/// lambda^2 at the beginning of each tick.
struct KalmanGains {
  Real alpha;
  Real beta;
  Real gamma;
};

namespace kalman {

// Slow filters have covariances that are many powers of ten apart.
using Wide = boost::multiprecision::cpp_bin_float_100;
using Wide3x3 = std::array<std::array<Wide, 3>, 3>;

inline Wide3x3 Times(const Wide3x3& a, const Wide3x3& b) {
  Wide3x3 product{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t k = 0; k < 3; ++k) {
        product[i][j] += a[i][k] * b[k][j];
      }
    }
  }
  return product;
}

inline Wide3x3 Sum(Wide3x3 a, const Wide3x3& b) {
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      a[i][j] += b[i][j];
    }
  }
  return a;
}

inline Wide3x3 Transposed(const Wide3x3& a) {
  Wide3x3 result{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      result[j][i] = a[i][j];
    }
  }
  return result;
}

// By cofactors, indices modulo 3.
inline Wide3x3 Inverse(const Wide3x3& a) {
  Wide3x3 cofactors{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      cofactors[i][j] = a[(i + 1) % 3][(j + 1) % 3] * a[(i + 2) % 3][(j + 2) % 3] -
                        a[(i + 1) % 3][(j + 2) % 3] * a[(i + 2) % 3][(j + 1) % 3];
    }
  }
  const Wide determinant = a[0][0] * cofactors[0][0] + a[0][1] * cofactors[0][1] + a[0][2] * cofactors[0][2];
  Wide3x3 inverse = Transposed(cofactors);
  for (auto& row : inverse) {
    for (Wide& entry : row) {
      entry /= determinant;
    }
  }
  return inverse;
}

}  // namespace kalman

/// Riccati's equation X = A' X (I + G X)^-1 A + H by structure-preserving doubling: each step squares what is
/// left of the error.
inline KalmanGains SolveRiccati(const Real& tracking_index) {
  using namespace kalman;  // NOLINT(google-build-using-namespace): 3x3 algebra of this function alone
  const Wide half = Wide(1) / 2;
  const Wide variance = Wide(tracking_index) * Wide(tracking_index);
  Wide3x3 a{{{1, 0, 0}, {1, 1, 0}, {half, 1, 1}}};  // transposed transition
  Wide3x3 g{};
  g[0][0] = 1;
  const std::array<Wide, 3> noise{half, 1, 1};
  Wide3x3 h{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      h[i][j] = variance * noise[i] * noise[j];
    }
  }
  const Wide3x3 identity{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (int i = 0; i < 60; ++i) {
    const Wide3x3 inverse = Inverse(Sum(identity, Times(g, h)));
    const Wide3x3 next_h = Sum(h, Times(Times(Times(Transposed(a), h), inverse), a));
    g = Sum(g, Times(Times(Times(a, inverse), g), Transposed(a)));
    a = Times(Times(a, inverse), a);
    h = next_h;
  }
  const Wide innovation = h[0][0] + 1;
  return {Real(h[0][0] / innovation), Real(h[0][1] / innovation), Real(h[0][2] / innovation)};
}

/// C(z) = (z - 1)^2 / T^2 numerator / denominator, in powers of z; of an accelerometer H(z) = numerator /
/// denominator.
struct ReferenceEstimator {
  RealPolynomial numerator;
  RealPolynomial denominator;
};

/// As estimator_kind.h says, nothing simplified.
inline ReferenceEstimator EstimatorIn50Digits(const LoopParameters& loop) {
  const Real angle = 2 * boost::math::constants::pi<Real>() * loop.cutoff_hz * loop.period_s;
  const Real a = exp(-angle);
  const Real g = tan(angle / 2);
  const Real root2 = sqrt(Real(2));
  const RealPolynomial two_ticks{0, 0, 1};
  switch (loop.estimator) {
    case EstimatorKind::kFilteredDifference:
      return {{0, 1 - a}, Times(two_ticks, {-a, 1})};
    case EstimatorKind::kLateFilteredDifference:
      return {{1 - a}, Times(two_ticks, {-a, 1})};
    case EstimatorKind::kButterworth: {
      // g^2 / (s^2 + sqrt(2) g s + g^2) at s = (z - 1)/(z + 1)
      const RealPolynomial denominator{1 - root2 * g + g * g, 2 * g * g - 2, 1 + root2 * g + g * g};
      return {{g * g, 2 * g * g, g * g}, Times(two_ticks, denominator)};
    }
    case EstimatorKind::kKalman: {
      const Real u = 4 * sin(angle / 2) * sin(angle / 2);
      const KalmanGains k = SolveRiccati(sqrt(u * u * u / (1 + u / 4)));
      // det(z I - (I - K H) F), by hand.
      const RealPolynomial denominator{k.alpha - 1, 3 - 2 * k.alpha - k.beta + k.gamma / 2,
                                       k.alpha + k.beta + k.gamma / 2 - 3, 1};
      return {{0, k.gamma}, denominator};
    }
    case EstimatorKind::kAccelerometer:
      return {{1}, {1}};
    case EstimatorKind::kFilteredAccelerometer:
      return {{0, 1 - a}, {-a, 1}};
  }
  return {};
}

}  // namespace mwidth::model
