#include "server/model/white_noise_gain.h"

#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

namespace mwidth::model {
namespace {

// A polynomial in v, the highest power first, as Routh's table reads it.
using Row = std::vector<double>;

// (1 - v)^degree p(2 v / (1 - v)): the polynomial in v = (z - 1)/(z + 1) = w/(w + 2) of one in w, taken as of
// that degree. Inside of the circle is left of the axis, and what is near z = 1 stays near 0.
Row Bilinear(const DifferencePolynomial& polynomial, std::size_t degree) {
  DifferencePolynomial mapped(degree + 1, 0.0);
  DifferencePolynomial power{1.0};  // (1 - v)^(degree - k)
  for (std::size_t k = degree + 1; k-- > 0;) {
    const double coefficient = k < polynomial.size() ? std::ldexp(polynomial[k], static_cast<int>(k)) : 0.0;
    for (std::size_t i = 0; i < power.size(); ++i) {
      mapped[k + i] += coefficient * power[i];
    }
    power = Multiply(power, {1.0, -1.0});
  }
  return {mapped.rbegin(), mapped.rend()};
}

// 1/(2 pi j) integral along the imaginary axis of |b / a|^2 dv, b of one degree less than a; none unless all
// roots of a are left of the axis. Each turn takes a row off the table: with a~ every other coefficient of a,
// from the second one, a - alpha v a~ and b - beta a~ are of one degree less, and the integral is smaller by
// beta^2 / (2 alpha).
std::optional<double> AxisIntegral(Row a, Row b) {
  double integral = 0;
  while (a.size() > 1) {
    const double alpha = a[0] / a[1];
    const double beta = b[0] / a[1];
    if (!(alpha > 0 && std::isfinite(alpha))) {
      return std::nullopt;
    }
    integral += beta * beta / (2 * alpha);
    for (std::size_t i = 1; i < a.size(); i += 2) {
      a[i - 1] -= alpha * a[i];
      b[i - 1] -= beta * a[i];
    }
    a.erase(a.begin());
    b.erase(b.begin());
  }
  return integral;
}

}  // namespace

std::optional<double> WhiteNoiseGain(const DifferencePolynomial& numerator,
                                     const DifferencePolynomial& denominator) {
  std::size_t common = 0;
  while (common < numerator.size() && numerator[common] == 0 && denominator[common] == 0) {
    ++common;
  }
  const auto skip = static_cast<std::ptrdiff_t>(common);
  const DifferencePolynomial top(numerator.begin() + skip, numerator.end());
  const DifferencePolynomial bottom(denominator.begin() + skip, denominator.end());
  const std::size_t degree = bottom.size() - 1;
  // dt = 2 dv / (j (1 - v^2)): the measure of the circle is a filter sqrt(2)/(1 + v) along the axis.
  Row a = Bilinear(bottom, degree);
  a.push_back(0);
  for (std::size_t i = a.size() - 1; i > 0; --i) {
    a[i] += a[i - 1];
  }
  Row b = Bilinear(top, degree);
  for (double& coefficient : b) {
    coefficient *= std::numbers::sqrt2;
  }
  return AxisIntegral(std::move(a), std::move(b));
}

}  // namespace mwidth::model
