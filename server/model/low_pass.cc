#include "server/model/low_pass.h"

#include <complex>

namespace mwidth::model {

EstimatorFactors KalmanLowPass::Factors(double period_s, double cutoff_hz) noexcept {
  const double half_sine = std::sin(std::numbers::pi * cutoff_hz * period_s);
  const double u0 = 4 * half_sine * half_sine;
  // u = rho y with rho = lambda^(2/3): y^3 - (rho/4) y + 1 = (y + v)(y^2 - v y + 1/v), and v by Cardano's
  // formula.
  const double rho = u0 / std::cbrt(1 + u0 / 4);
  const double third = rho / 12;
  const double cardano = std::cbrt(0.5 + std::sqrt(0.25 - third * third * third));
  const double v = cardano + third / cardano;

  // Each u is that of two values of w, w^2 + u w + u = 0, one inside the unit circle. For u = -rho v it is
  // -f.
  const double real_u = rho * v;
  const double root = std::sqrt(real_u * (real_u + 4));
  const double f = 2 * real_u / (real_u + root);
  const double a = 2 / (2 + real_u + root);

  const std::complex<double> u = rho * std::complex<double>(v / 2, std::sqrt(1 / v - v * v / 4));
  const std::complex<double> w = -(u + std::sqrt(u * (u - 4.0))) / 2.0;  // the root with a real part above 0
  const double q = std::norm(w);
  const double loss = -2 * w.real() - q;
  return {.gain = f * q,
          .half_rate_zero_pairs = 0,
          .lag_ticks = -1,
          .pole_count = 2,
          .poles = {{{.degree = 2, .circle = {q, -std::norm(w + 2.0), loss}},
                     {.degree = 1, .circle = {f, 2 - f, a}}}}};
}

}  // namespace mwidth::model
