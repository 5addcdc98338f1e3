#include "server/model/linear_estimator.h"

#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>

#include "server/model/estimator.h"

namespace mwidth::model {

std::complex<double> Evaluate(const DifferencePolynomial& polynomial, std::complex<double> w) {
  std::complex<double> value = 0;
  for (std::size_t i = polynomial.size(); i-- > 0;) {
    value = value * w + polynomial[i];
  }
  return value;
}

DifferencePolynomial Multiply(const DifferencePolynomial& a, const DifferencePolynomial& b) {
  DifferencePolynomial product(a.size() + b.size() - 1, 0.0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t k = 0; k < b.size(); ++k) {
      product[i + k] += a[i] * b[k];
    }
  }
  return product;
}

CircleFrequency AtFrequency(double frequency_hz, double period_s) {
  const double half_angle = std::numbers::pi * frequency_hz * period_s;
  const double sine = std::sin(half_angle);
  const std::complex<double> w(-2 * sine * sine, 2 * sine * std::cos(half_angle));
  return {.z = 1.0 + w, .w = w};
}

LinearEstimator EstimatorOf(const LoopParameters& loop) {
  if (IsAccelerometer(loop.estimator)) {
    throw std::invalid_argument("an accelerometer's signal is no function of sampled positions");
  }
  const EstimatorFactors factors = FactorsOf(loop.estimator, loop.period_s, loop.cutoff_hz);
  LinearEstimator estimator{.numerator = {0, 0, factors.gain / (loop.period_s * loop.period_s)},
                            .denominator = {1}};
  const DifferencePolynomial z{1, 1};
  for (int i = 0; i < factors.half_rate_zero_pairs; ++i) {
    estimator.numerator = Multiply(estimator.numerator, {4, 4, 1});
  }
  for (int lag = factors.lag_ticks; lag < 0; ++lag) {
    estimator.numerator = Multiply(estimator.numerator, z);
  }
  for (int lag = factors.lag_ticks; lag > 0; --lag) {
    estimator.denominator = Multiply(estimator.denominator, z);
  }
  for (const PoleFactor& pole : factors) {
    const auto coefficients = pole.Coefficients();
    estimator.denominator =
        Multiply(estimator.denominator,
                 DifferencePolynomial(coefficients.begin(), coefficients.begin() + 1 + pole.degree));
  }
  return estimator;
}

LinearEstimator AccelerometerFilter(const LoopParameters& loop) {
  if (loop.estimator == EstimatorKind::kAccelerometer) {
    return {.numerator = {1}, .denominator = {1}};
  }
  const double gap = FirstOrderLowPass::Factors(loop.period_s, loop.cutoff_hz).gain;
  return {.numerator = {gap, gap}, .denominator = {gap, 1}};
}

}  // namespace mwidth::model
