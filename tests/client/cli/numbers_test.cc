#include "client/cli/numbers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace mwidth::cli {
namespace {

TEST(RoundedTest, KeepsTheDigitsThatArePresent) {
  EXPECT_EQ(Rounded(0.35), "0.35");
  EXPECT_EQ(Rounded(-0.0512345678), "-0.0512346");
  EXPECT_EQ(Rounded(std::numeric_limits<double>::infinity()), "inf");
}

TEST(RoundedTowardZeroTest, NeverLeavesTheIntervalThatItsArgumentBounds) {
  EXPECT_EQ(RoundedTowardZero(0.3512345678), "0.351234");
  EXPECT_EQ(RoundedTowardZero(0.35), "0.35");
  EXPECT_EQ(RoundedTowardZero(0.0), "0");
  EXPECT_EQ(RoundedTowardZero(-std::numeric_limits<double>::infinity()), "-inf");
  EXPECT_EQ(RoundedTowardZero(0.9999999, 3), "0.999");
  EXPECT_EQ(RoundedTowardZero(-99.99999, 3), "-99.9");

  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> mantissa(-1, 1);
  std::uniform_int_distribution<int> exponent(-12, 12);
  for (int i = 0; i < 10'000; ++i) {
    const double value = mantissa(random) * std::pow(10.0, exponent(random));
    const double printed = std::stod(RoundedTowardZero(value));
    EXPECT_LE(std::abs(printed), std::abs(value)) << value;
    EXPECT_NEAR(printed, value, 1.1e-5 * std::abs(value));
  }
}

TEST(ExactTest, ReadsBackToTheSameNumber) {
  EXPECT_EQ(Exact(0.1), "0.10000000000000001");
  for (const double value : {1.0 / 3, -2e-300, 1e300, 0.0}) {
    EXPECT_EQ(std::stod(Exact(value)), value);
  }
}

}  // namespace
}  // namespace mwidth::cli
