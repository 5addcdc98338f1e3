#include "server/model/linear_estimator.h"

#include <cmath>
#include <cstddef>
#include <numbers>

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

LinearEstimator PaperEstimator(double period_s, double cutoff_hz) {
  const double f = -std::expm1(-2 * std::numbers::pi * cutoff_hz * period_s);
  return {.numerator = {0, 0, f / (period_s * period_s)}, .denominator = {f, 1 + f, 1}};
}

}  // namespace mwidth::model
