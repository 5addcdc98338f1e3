#include "server/render/limits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

namespace mwidth::render {
namespace {

TEST(LimitsTest, RoundsAForceToTheNearestCount) {
  EXPECT_EQ(LimitForce(1.2344, 1e-3, 10'000).counts, 1234);
  EXPECT_EQ(LimitForce(-1.2346, 1e-3, 10'000).counts, -1235);
  EXPECT_EQ(LimitForce(0.0004, 1e-3, 10'000).counts, 0);
  EXPECT_FALSE(LimitForce(1.2344, 1e-3, 10'000).saturated);
}

TEST(LimitsTest, ClampsAForceOfEitherSignAndSaysSo) {
  EXPECT_EQ(LimitForce(50, 1e-3, 20'000).counts, 20'000);
  EXPECT_TRUE(LimitForce(50, 1e-3, 20'000).saturated);
  EXPECT_EQ(LimitForce(-1e300, 1e-3, 20'000).counts, -20'000);
  EXPECT_TRUE(LimitForce(-1e300, 1e-3, 20'000).saturated);
  EXPECT_EQ(LimitForce(20, 1e-3, 20'000).counts, 20'000);
  EXPECT_FALSE(LimitForce(20, 1e-3, 20'000).saturated);
}

TEST(LimitsTest, NeverAllowsACountWhoseForceIsBeyondTheLimit) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> exponent(-6, 2);
  for (int i = 0; i < 100'000; ++i) {
    const double quantum = std::pow(10, exponent(random)) * 1e-4;
    // Every other limit just below a whole number of counts, where the division rounds up to it.
    const double limit = i % 2 == 0 ? std::pow(10, exponent(random)) : std::nextafter((i + 1) * quantum, 0);
    const int32_t counts = LargestForceCounts(limit, quantum);
    ASSERT_GE(counts, 0);
    ASSERT_LE(counts * quantum, limit);
    if (counts < std::numeric_limits<int32_t>::max()) {
      ASSERT_GT((counts + 1) * quantum, limit * (1 - 1e-12));
    }
  }
}

TEST(LimitsTest, StaysWithinTheIntegersOfTheDrive) {
  EXPECT_EQ(LargestForceCounts(1e6, 1e-6), std::numeric_limits<int32_t>::max());
  EXPECT_EQ(LimitForce(1e9, 1e-6, std::numeric_limits<int32_t>::max()).counts,
            std::numeric_limits<int32_t>::max());
}

TEST(LimitsTest, CommandsNothingWhereTheLimitIsBelowOneCount) { EXPECT_EQ(LargestForceCounts(0.5, 1), 0); }

TEST(LimitsTest, ScalesPositionsByTheQuantum) { EXPECT_EQ(PositionOf(-250'000, 1e-6), -250'000 * 1e-6); }

TEST(LimitsTest, AllowsTheStepsOfASlewLimitInWholeCountsAndAnyStepWhereThereIsNone) {
  EXPECT_EQ(LargestStepCounts(30, 1e-3, 1e-3, 8000), 30);
  EXPECT_EQ(LargestStepCounts(30.9, 1e-3, 1e-3, 8000), 30);
  EXPECT_EQ(LargestStepCounts(1, 1e-3, 1e-3, 8000), 1);
  EXPECT_EQ(LargestStepCounts(std::numeric_limits<double>::infinity(), 1e-3, 1e-3, 8000), 16'000);
  const int32_t largest = std::numeric_limits<int32_t>::max();
  EXPECT_EQ(LargestStepCounts(1e300, 1e-3, 1e-3, largest), 2LL * largest);
}

TEST(LimitsTest, StaysWithinAStepOfTheForceThatActs) {
  EXPECT_EQ(LimitStep({.counts = 50}, 0, 30).counts, 30);
  EXPECT_TRUE(LimitStep({.counts = 50}, 0, 30).slew_limited);
  EXPECT_EQ(LimitStep({.counts = -50}, 0, 30).counts, -30);
  EXPECT_EQ(LimitStep({.counts = 50}, 20, 30).counts, 50);
  EXPECT_FALSE(LimitStep({.counts = 50}, 20, 30).slew_limited);
  EXPECT_TRUE(LimitStep({.counts = 50, .saturated = true}, 0, 30).saturated);
  // From one end of the drive's integers to the other.
  const int32_t largest = std::numeric_limits<int32_t>::max();
  EXPECT_EQ(LimitStep({.counts = largest}, -largest, 2LL * largest).counts, largest);
  EXPECT_EQ(LimitStep({.counts = -largest}, largest, 1).counts, largest - 1);
}

}  // namespace
}  // namespace mwidth::render
