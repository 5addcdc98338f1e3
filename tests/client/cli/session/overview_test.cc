#include "client/cli/session/overview.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace mwidth::cli::session {
namespace {

using exchange::Sample;
using exchange::State;

Sample At(uint64_t tick, double position = 0, State state = State::kRendering) {
  Sample sample;
  sample.tick = tick;
  sample.position = position;
  sample.state = state;
  return sample;
}

TEST(OverviewTest, KeepsEveryPeakOfAnHourInTheSamePlace) {
  constexpr uint64_t kFirst = 1'000;
  constexpr uint64_t kTicks = 3'600'000;
  Overview overview(kFirst, kFirst + kTicks - 1, 1e-3);
  for (uint64_t k = 0; k < kTicks; ++k) {
    overview.Add(At(kFirst + k, k == 1'800'000 ? 1 : 0));
  }
  const auto curve = overview.Position();
  EXPECT_LE(curve.size(), 1400);
  const auto peak = std::max_element(curve.begin(), curve.end(), [](auto& a, auto& b) { return a.y < b.y; });
  EXPECT_EQ(peak->y, 1);
  EXPECT_NEAR(peak->x, 1800, 3600.0 / 700);
  EXPECT_EQ(overview.samples(), kTicks);
  EXPECT_EQ(overview.length_s(), 3600);
}

TEST(OverviewTest, InterruptsTheCurveWhereNothingWasRecorded) {
  Overview overview(0, 69'999, 1e-3);
  for (uint64_t tick = 0; tick < 70'000; tick += tick == 20'000 ? 30'000 : 1) {
    overview.Add(At(tick));
  }
  const auto curve = overview.Position();
  EXPECT_NEAR(static_cast<double>(
                  std::count_if(curve.begin(), curve.end(), [](auto& point) { return std::isnan(point.y); })),
              300, 1);
}

TEST(OverviewTest, TellsStatesAndWhatClampedTheForce) {
  Overview overview(0, 99, 1e-3);
  for (uint64_t tick = 0; tick < 100; ++tick) {
    Sample sample = At(tick, 0, tick < 20 ? State::kIdle : tick < 90 ? State::kRendering : State::kFault);
    sample.saturated = tick % 2 == 0;
    sample.slew_limited = tick % 4 == 0;
    sample.position_stale = tick % 10 == 0;
    sample.force = tick == 50 ? -3 : 1;
    overview.Add(sample);
  }
  ASSERT_EQ(overview.states().size(), 3);
  EXPECT_NEAR(overview.states()[1].from_s, 0.02, 1e-12);
  EXPECT_NEAR(overview.states()[1].to_s, 0.09, 1e-12);
  EXPECT_EQ(overview.state_ticks()[static_cast<std::size_t>(State::kRendering)], 70);
  EXPECT_EQ(overview.saturated_ticks(), 50);
  EXPECT_EQ(overview.slew_limited_ticks(), 25);
  EXPECT_EQ(overview.stale_ticks(), 10);
  EXPECT_EQ(overview.largest_force(), 3);
}

TEST(OverviewTest, CountsWhatLiesOutsideOfItsTicksWithoutShowingIt) {
  Overview overview(100, 199, 1e-3);
  overview.Add(At(50, 7));
  overview.Add(At(300, 7));
  EXPECT_EQ(overview.samples(), 2);
  for (const Point& point : overview.Position()) {
    EXPECT_TRUE(std::isnan(point.y));
  }
  EXPECT_TRUE(overview.states().empty());
}

}  // namespace
}  // namespace mwidth::cli::session
