#include "server/model/white_noise_gain.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <cstddef>
#include <random>

namespace mwidth::model {
namespace {

// The polynomial in w with the given roots in z.
DifferencePolynomial FromRoots(const std::vector<std::complex<double>>& roots) {
  DifferencePolynomial product{1};
  for (const std::complex<double>& root : roots) {
    // Of a pair, the one below the axis is left out by the caller.
    product = root.imag() == 0 ? Multiply(product, {1 - root.real(), 1})
                               : Multiply(product, {std::norm(1.0 - root), 2 * (1 - root.real()), 1});
  }
  return product;
}

// The mean of |filter|^2 over the circle: for a smooth periodic function the sum over equal steps converges
// like the slowest pole to the power of their number.
double MeanSquare(const DifferencePolynomial& numerator, const DifferencePolynomial& denominator) {
  constexpr int kSteps = 4000;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const CircleFrequency at = AtFrequency((i + 0.5) / kSteps, 1);
    sum += std::norm(Evaluate(numerator, at.w) / Evaluate(denominator, at.w));
  }
  return sum / kSteps;
}

TEST(WhiteNoiseGain, OfAFirstOrderLagIsTheGeometricSeries) {
  for (const double pole : {-0.99, -0.3, 0.0, 0.5, 0.999}) {
    // 1 / (z - pole)
    EXPECT_NEAR(*WhiteNoiseGain({1}, {1 - pole, 1}) * (1 - pole * pole), 1, 1e-13);
  }
}

TEST(WhiteNoiseGain, OfPureDelayIsOne) {
  EXPECT_NEAR(*WhiteNoiseGain({1}, Multiply({1, 1}, Multiply({1, 1}, {1, 1}))), 1, 1e-14);
  EXPECT_NEAR(*WhiteNoiseGain({3}, {1}), 9, 1e-14);
}

TEST(WhiteNoiseGain, EqualsTheMeanSquareAlongTheCircle) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < 200; ++i) {
    const DifferencePolynomial denominator =
        FromRoots({0.98 * uniform(random), 0.98 * uniform(random), 0.0, 0.0,
                   std::polar(0.98, 3 * uniform(random)), std::polar(0.5, 3 * uniform(random))});
    DifferencePolynomial numerator(denominator.size());
    for (double& coefficient : numerator) {
      coefficient = uniform(random);
    }
    const double expected = MeanSquare(numerator, denominator);
    EXPECT_NEAR(*WhiteNoiseGain(numerator, denominator) / expected, 1, 1e-9) << i;
  }
}

TEST(WhiteNoiseGain, KeepsItsAccuracyForPolesSlowAgainstTheSampleRate) {
  // w^2 + 2 zeta r w + r^2 with r = 1e-6 has poles 1e-6 from z = 1; its step weighs 1/(4 zeta r^3) to first
  // order in r.
  const double r = 1e-6;
  const double zeta = 0.3;
  EXPECT_NEAR(*WhiteNoiseGain({1}, {r * r, 2 * zeta * r, 1}) * 4 * zeta * r * r * r, 1, 5e-6);
}

TEST(WhiteNoiseGain, SaysWhenThereIsNone) {
  EXPECT_FALSE(WhiteNoiseGain({1}, FromRoots({1.001})));
  EXPECT_FALSE(WhiteNoiseGain({1}, FromRoots({-1.001})));
  EXPECT_FALSE(WhiteNoiseGain({1}, FromRoots({1.0})));
  EXPECT_FALSE(WhiteNoiseGain({1}, FromRoots({0.5, std::polar(1.0001, 2.0), 0.2})));
  EXPECT_TRUE(WhiteNoiseGain({1}, FromRoots({0.5, std::polar(0.9999, 2.0), 0.2})));
}

TEST(WhiteNoiseGain, CancelsWhatBothHaveAtStandstill) {
  const DifferencePolynomial denominator = FromRoots({0.3, 0.9});
  EXPECT_NEAR(*WhiteNoiseGain({0, 0, 2, 1}, Multiply(denominator, {0, 1})),
              *WhiteNoiseGain({0, 2, 1}, denominator), 1e-14);
}

}  // namespace
}  // namespace mwidth::model
