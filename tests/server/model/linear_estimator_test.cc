#include "server/model/linear_estimator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "server/model/estimator.h"

namespace mwidth::model {
namespace {

using std::numbers::pi;

// The response of the running estimator to one count, transformed.
std::complex<double> TransformOfRunning(const LoopParameters& loop, double turns) {
  AccelerationEstimator running(loop.period_s, loop.cutoff_hz, loop.estimator);
  running.Reset(0);
  std::complex<double> transform = 0;
  for (int k = 0; k < 20000; ++k) {
    transform += running.Update(k == 0 ? 1 : 0) * std::polar(1.0, -2 * pi * turns * k);
  }
  return transform;
}

TEST(LinearEstimator, IsWhatTheLoopRuns) {
  for (const EstimatorKind kind : kEstimatorKinds) {
    for (const double period_s : {1e-2, 1e-3, 1e-4}) {
      for (const double cutoff_period : {0.001, 0.01, 0.2, CutoffRangeOf(kind).max}) {
        const LoopParameters loop{
            .period_s = period_s, .cutoff_hz = cutoff_period / period_s, .estimator = kind};
        const LinearEstimator estimator = EstimatorOf(loop);
        for (const double turns : {0.003, 0.05, 0.31, 0.5}) {
          const std::complex<double> response = estimator.Response(AtFrequency(turns / period_s, period_s));
          // Against the size of the impulse response, which cancels down to C near z = 1.
          EXPECT_LT(std::abs(TransformOfRunning(loop, turns) - response),
                    1e-9 * std::abs(estimator.Response(AtFrequency(0.4 / period_s, period_s))))
              << Name(kind) << " " << period_s << " " << loop.cutoff_hz << " " << turns;
        }
      }
    }
  }
}

TEST(LinearEstimator, EstimatesAccelerationOfSlowMotion) {
  const LinearEstimator estimator = EstimatorOf({.period_s = 1e-5, .cutoff_hz = 100});
  const double w = 2 * pi * 1e-4;
  const std::complex<double> response = estimator.Response(AtFrequency(1e-4, 1e-5));
  // Relative accuracy also where z - 1 is 6e-9; the lag is 1/w0 of the filter and T/2 besides: a period of
  // the double difference less half of one, because the filter uses the newest sample.
  EXPECT_NEAR(response.real() / (w * w), -1, 1e-11);
  EXPECT_NEAR(response.imag() / (w * w), 1e-6 + w * 5e-6, 1e-11);
}

TEST(LinearEstimator, MultipliesPolynomials) {
  EXPECT_EQ(Multiply({1, 2}, {3, 0, -1}), (DifferencePolynomial{3, 6, -1, -2}));
}

}  // namespace
}  // namespace mwidth::model
