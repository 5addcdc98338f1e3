// What runs is what is certified: recurrences, factors and definitions of every estimator held against each
// other.
#include "server/model/low_pass.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "server/model/estimator.h"
#include "server/model/linear_estimator.h"
#include "tests/server/model/reference_estimator.h"

namespace mwidth::model {
namespace {

// From slow filters at 100 kHz to the fastest that each estimator runs.
std::vector<LoopParameters> Estimators() {
  std::vector<LoopParameters> estimators;
  for (const EstimatorKind kind : kEstimatorKinds) {
    for (const double period_s : {1e-5, 1e-3, 1e-2}) {
      for (const double share : {1e-5, 1e-3, 0.02, 0.2, CutoffRangeOf(kind).max}) {
        estimators.push_back({.period_s = period_s, .cutoff_hz = share / period_s, .estimator = kind});
      }
    }
  }
  return estimators;
}

std::string Describe(const LoopParameters& loop) {
  return std::string(Name(loop.estimator)) + " " + std::to_string(loop.cutoff_hz * loop.period_s);
}

// The first `count` values of the series of `numerator` over the estimator's denominator and T^2 in powers of
// 1/z, in 50 digits.
std::vector<Real> Response(const LoopParameters& loop, const RealPolynomial& numerator, std::size_t count) {
  const ReferenceEstimator estimator = EstimatorIn50Digits(loop);
  const RealPolynomial& denominator = estimator.denominator;
  const std::size_t lag = denominator.size() - numerator.size();
  std::vector<Real> response(count);
  for (std::size_t n = 0; n < count; ++n) {
    Real value =
        n >= lag && n - lag < numerator.size() ? numerator[numerator.size() - 1 - (n - lag)] : Real(0);
    for (std::size_t k = 1; k < denominator.size() && k <= n; ++k) {
      value -= denominator[denominator.size() - 1 - k] * response[n - k];
    }
    response[n] = value / denominator.back();
  }
  for (Real& value : response) {
    value /= Real(loop.period_s) * loop.period_s;
  }
  return response;
}

double LargestDifference(AccelerationEstimator running, const std::vector<Real>& expected,
                         const std::function<double(std::size_t)>& position) {
  running.Reset(0);
  double largest = 0;
  for (std::size_t k = 0; k < expected.size(); ++k) {
    largest = std::max(largest, std::abs(static_cast<double>(running.Update(position(k)) - expected[k])));
  }
  return largest;
}

TEST(LowPass, RunsTheTransferFunctionOfItsDefinition) {
  constexpr std::size_t kTicks = 2000;
  for (const LoopParameters& loop : Estimators()) {
    const AccelerationEstimator running(loop.period_s, loop.cutoff_hz, loop.estimator);
    const RealPolynomial numerator = EstimatorIn50Digits(loop).numerator;
    // A ramp z^2/(z - 1)^2 is one impulse of the double difference.
    const std::vector<Real> ramp = Response(loop, Times({0, 0, 1}, numerator), kTicks);
    const auto largest = static_cast<double>(*std::max_element(
        ramp.begin(), ramp.end(), [](const Real& a, const Real& b) { return abs(a) < abs(b); }));
    EXPECT_LT(LargestDifference(running, ramp, [](std::size_t k) { return static_cast<double>(k + 1); }),
              1e-13 * std::abs(largest))
        << Describe(loop);
    // An impulse of position is the ramp's second difference: rounded as what it is the difference of.
    const std::vector<Real> impulse = Response(loop, Times({1, -2, 1}, numerator), kTicks);
    EXPECT_LT(LargestDifference(running, impulse, [](std::size_t k) { return k == 0 ? 1.0 : 0.0; }),
              1e-13 * std::abs(largest))
        << Describe(loop);
  }
}

TEST(LowPass, HasTheFactorsOfItsDefinition) {
  for (const LoopParameters& loop : Estimators()) {
    const ReferenceEstimator reference = EstimatorIn50Digits(loop);
    const EstimatorFactors factors = FactorsOf(loop.estimator, loop.period_s, loop.cutoff_hz);
    const LinearEstimator expanded = EstimatorOf(loop);
    for (const double angle : {1e-4, 0.01, 0.3, 1.5, 3.0}) {
      // C T^2/w^2 in 50 digits: sums of powers of z, so neither real nor imaginary part may be had in less.
      const auto value = [angle](const RealPolynomial& polynomial) {
        std::array<Real, 2> sum{};
        for (std::size_t k = 0; k < polynomial.size(); ++k) {
          sum[0] += polynomial[k] * cos(Real(angle) * k);
          sum[1] += polynomial[k] * sin(Real(angle) * k);
        }
        return sum;
      };
      const auto [n_re, n_im] = value(reference.numerator);
      const auto [d_re, d_im] = value(reference.denominator);
      const Real size = d_re * d_re + d_im * d_im;
      const std::complex<double> expected(static_cast<double>((n_re * d_re + n_im * d_im) / size),
                                          static_cast<double>((n_im * d_re - n_re * d_im) / size));

      const double half_sine = std::sin(angle / 2);
      const CirclePoint at{half_sine * half_sine, std::cos(angle / 2) * std::cos(angle / 2)};
      std::complex<double> actual = factors.gain * std::pow(4 * at.c, factors.half_rate_zero_pairs);
      // (z + 1)^2 = 4 c z; conj(z conj(B)) = B / z
      int turns = factors.half_rate_zero_pairs - factors.lag_ticks;
      for (const PoleFactor& pole : factors) {
        const CircleFactor& circle = pole.circle;
        const std::complex<double> b(circle.at_c * at.c + circle.at_s * at.s, circle.turn * std::sin(angle));
        EXPECT_NEAR(std::norm(b) / pole.SizeSquared(at), 1, 1e-14);
        actual /= b;
        --turns;
      }
      actual *= std::polar(1.0, turns * angle);
      EXPECT_LT(std::abs(actual / expected - 1.0), 2e-14) << Describe(loop) << " " << angle;

      const CircleFrequency point{std::polar(1.0, angle), {-2 * half_sine * half_sine, std::sin(angle)}};
      const std::complex<double> response =
          expanded.Response(point) / (point.w * point.w) * loop.period_s * loop.period_s;
      EXPECT_LT(std::abs(response / expected - 1.0), 1e-12) << Describe(loop) << " " << angle;
    }
  }
}

TEST(LowPass, HasItsPolesInsideTheUnitCircle) {
  for (const LoopParameters& loop : Estimators()) {
    for (const PoleFactor& pole : FactorsOf(loop.estimator, loop.period_s, loop.cutoff_hz)) {
      // B at z = 1 and at z = -1 of the sign that a root inside leaves, and its product of roots below 1.
      EXPECT_GT(pole.circle.at_c, 0) << Describe(loop);
      EXPECT_GT(pole.degree == 1 ? pole.circle.at_s : -pole.circle.at_s, 0) << Describe(loop);
      EXPECT_GT(pole.circle.turn, 0) << Describe(loop);
    }
  }
}

TEST(LowPass, OfSecondAndThirdOrderAre3DecibelsDownAtTheCutoff) {
  for (const LoopParameters& loop : Estimators()) {
    if (loop.estimator != EstimatorKind::kButterworth && loop.estimator != EstimatorKind::kKalman) {
      continue;
    }
    const CircleFrequency at = AtFrequency(loop.cutoff_hz, loop.period_s);
    const double difference = std::norm(at.w) / (loop.period_s * loop.period_s);
    EXPECT_NEAR(std::norm(EstimatorOf(loop).Response(at)) / (difference * difference), 0.5, 1e-12)
        << Describe(loop);
  }
}

TEST(LowPass, OfKalmanIsTheFilterOfPositionVelocityAndAcceleration) {
  for (const double share : {0.003, 0.05, 0.5}) {
    const LoopParameters loop{
        .period_s = 1e-3, .cutoff_hz = share * 1e3, .estimator = EstimatorKind::kKalman};
    const double u = 4 * std::pow(std::sin(std::acos(-1.0) * share), 2);
    const KalmanGains gains = SolveRiccati(sqrt(Real(u) * u * u / (1 + u / 4)));
    AccelerationEstimator running(loop.period_s, loop.cutoff_hz, loop.estimator);
    running.Reset(0);
    Real x = 0;
    Real v = 0;
    Real a = 0;
    for (int k = 1; k < 500; ++k) {
      const double measured = std::sin(0.02 * k) + 1e-4 * std::sin(7.3 * k * k);
      x += v + a / 2;
      v += a;
      const Real innovation = measured - x;
      x += gains.alpha * innovation;
      v += gains.beta * innovation;
      a += gains.gamma * innovation;
      EXPECT_NEAR(running.Update(measured), static_cast<double>(a * 1e6), 1e-8) << share << " " << k;
    }
  }
}

TEST(LowPass, OfKalmanObeysKalatasRelationOfGainsAndTrackingIndex) {
  for (const double share : {1e-4, 0.01, 0.3}) {
    const double u = 4 * std::pow(std::sin(std::acos(-1.0) * share), 2);
    const Real index = sqrt(Real(u) * u * u / (1 + u / 4));
    const KalmanGains gains = SolveRiccati(index);
    EXPECT_LT(abs(gains.gamma * gains.gamma / (1 - gains.alpha) / (index * index) - 1), Real(1e-40));
    const double gamma = FactorsOf(EstimatorKind::kKalman, 1e-3, share * 1e3).gain;
    EXPECT_NEAR(gamma / static_cast<double>(gains.gamma), 1, 1e-14);
  }
}

}  // namespace
}  // namespace mwidth::model
