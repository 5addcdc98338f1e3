#include "server/render/time_allowance.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <deque>
#include <numeric>
#include <random>

namespace mwidth::render {
namespace {

TEST(TimeAllowanceTest, IsExceededByMoreThanWhatIsAllowedAndNotByAsMuch) {
  TimeAllowance allowance(1e-3, 1, 0.1);
  allowance.Pass(100, true);
  EXPECT_FALSE(allowance.Exceeded());
  EXPECT_DOUBLE_EQ(allowance.spent_s(), 0.1);
  allowance.Pass(1, true);
  EXPECT_TRUE(allowance.Exceeded());
  EXPECT_DOUBLE_EQ(allowance.allowed_s(), 0.1);
}

TEST(TimeAllowanceTest, AddsUpWhatComesAndGoes) {
  TimeAllowance often(1e-3, 1, 0.1);
  TimeAllowance seldom(1e-3, 1, 0.1);
  bool exceeded = false;
  for (int i = 0; i < 10'000; ++i) {
    often.Pass(1, i % 9 == 0);
    seldom.Pass(1, i % 11 == 0);
    exceeded = exceeded || often.Exceeded();
    ASSERT_FALSE(seldom.Exceeded());
    ASSERT_TRUE(often.Exceeded() || i < 1000);
  }
  EXPECT_TRUE(exceeded);
}

TEST(TimeAllowanceTest, ForgetsWhatTheWindowHasLeftBehind) {
  TimeAllowance allowance(1e-3, 1, 0.1);
  allowance.Pass(101, true);
  allowance.Pass(1000 - 102, false);
  EXPECT_TRUE(allowance.Exceeded());
  allowance.Pass(180, false);
  EXPECT_FALSE(allowance.Exceeded());
  EXPECT_EQ(allowance.spent_s(), 0);
}

TEST(TimeAllowanceTest, NeverCountsLessThanTheExactWindowAndAtMostTwoStepsMore) {
  std::mt19937_64 random(3);
  for (const uint64_t window : {1U, 10U, 31U, 32U, 33U, 100U, 999U, 1000U}) {
    TimeAllowance allowance(1e-3, static_cast<double>(window) * 1e-3, 0);
    const uint64_t step = (window + 31) / 32;
    std::deque<int> ticks;  // The newest first.
    for (int i = 0; i < 3000; ++i) {
      const uint64_t passing = random() % 20 == 0 ? random() % (3 * window) : random() % 4;
      const bool spent = random() % 3 == 0;
      allowance.Pass(passing, spent);
      ticks.insert(ticks.begin(), passing, spent ? 1 : 0);
      ticks.resize(window + 3 * step);
      const auto spent_in = [&ticks](uint64_t newest) {
        return std::accumulate(ticks.begin(), ticks.begin() + static_cast<int64_t>(newest), 0) * 1e-3;
      };
      ASSERT_GE(allowance.spent_s(), spent_in(window) - 1e-12);
      ASSERT_LE(allowance.spent_s(), spent_in(window + 2 * step) + 1e-12);
    }
  }
}

TEST(TimeAllowanceTest, IsSpentByAPauseLongerThanTheWindowInBoundedTime) {
  TimeAllowance allowance(1e-4, 10, 9);
  allowance.Pass(UINT64_MAX, true);
  EXPECT_TRUE(allowance.Exceeded());
  EXPECT_LE(allowance.spent_s(), 10 * (1 + 2.0 / 32));
  allowance.Pass(UINT64_MAX, false);
  EXPECT_EQ(allowance.spent_s(), 0);
}

TEST(TimeAllowanceTest, BeginsAnew) {
  TimeAllowance allowance(1e-3, 1, 0.1);
  allowance.Pass(500, true);
  allowance.Reset();
  EXPECT_EQ(allowance.spent_s(), 0);
  allowance.Pass(100, true);
  EXPECT_FALSE(allowance.Exceeded());
}

}  // namespace
}  // namespace mwidth::render
