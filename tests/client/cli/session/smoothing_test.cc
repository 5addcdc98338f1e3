#include "client/cli/session/smoothing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace mwidth::cli::session {
namespace {

TEST(SmoothingTest, HasTheWindowOfThePythonPackageWhereHalvesAreRoundedToEven) {
  EXPECT_EQ(Smoothing(1e-3).window(), 61);   // 30.5 rounds to 30.
  EXPECT_EQ(Smoothing(2e-4).window(), 305);  // 152.5 to 152.
  EXPECT_EQ(Smoothing(1e-2).window(), 7);
}

TEST(SmoothingTest, LeavesAPolynomialOfFifthOrderAndItsDerivativesAsTheyAreEndsIncluded) {
  constexpr double kPeriodS = 1e-3;
  std::vector<double> x(200);
  for (std::size_t k = 0; k < x.size(); ++k) {
    const double t = static_cast<double>(k) * kPeriodS;
    x[k] = 1 + t * (2 + t * (-3 + t * (40 + t * (-50 + t * 600))));
  }
  const Smoothing smoothing(kPeriodS);
  const auto position = smoothing.Apply(x, 0);
  const auto velocity = smoothing.Apply(x, 1);
  const auto acceleration = smoothing.Apply(x, 2);
  for (std::size_t k = 0; k < x.size(); ++k) {
    const double t = static_cast<double>(k) * kPeriodS;
    ASSERT_NEAR(position[k], x[k], 1e-12) << k;
    ASSERT_NEAR(velocity[k], 2 + t * (-6 + t * (120 + t * (-200 + t * 3000))), 1e-9) << k;
    ASSERT_NEAR(acceleration[k], -6 + t * (240 + t * (-600 + t * 12000)), 1e-5) << k;
  }
}

TEST(SmoothingTest, HasNoLag) {
  constexpr double kPeriodS = 1e-3;
  constexpr double kOmega = 2 * std::numbers::pi * 2;
  std::vector<double> x(2000);
  for (std::size_t k = 0; k < x.size(); ++k) {
    x[k] = std::sin(kOmega * static_cast<double>(k) * kPeriodS);
  }
  const Smoothing smoothing(kPeriodS);
  const auto velocity = smoothing.Apply(x, 1);
  const auto acceleration = smoothing.Apply(x, 2);
  for (std::size_t k = 50; k < 1950; ++k) {
    ASSERT_NEAR(velocity[k], kOmega * std::cos(kOmega * static_cast<double>(k) * kPeriodS), 1e-4 * kOmega);
    ASSERT_NEAR(acceleration[k], -kOmega * kOmega * x[k], 1e-3 * kOmega * kOmega);
  }
}

TEST(SmoothingTest, RefusesARowShorterThanItsWindow) {
  const Smoothing smoothing(1e-3);
  EXPECT_THROW(smoothing.Apply(std::vector<double>(60), 0), std::invalid_argument);
  EXPECT_EQ(smoothing.Apply(std::vector<double>(61), 0).size(), 61);
}

}  // namespace
}  // namespace mwidth::cli::session
