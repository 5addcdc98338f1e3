#include "server/exchange/tick_statistics.h"

#include <gtest/gtest.h>

#include <memory>

namespace mwidth::exchange {
namespace {

TEST(TickStatisticsTest, GathersEachDurationByItself) {
  const auto statistics = std::make_unique<TickStatistics>();
  statistics->Record({.wake_latency_ns = 10, .io_ns = 20, .compute_ns = 30, .loop_delay_ns = 40});
  statistics->Record({.wake_latency_ns = 11, .io_ns = 21, .compute_ns = 31, .loop_delay_ns = 41});
  EXPECT_EQ(statistics->wake_latency().Figures().min_ns, 10);
  EXPECT_EQ(statistics->io().Figures().min_ns, 20);
  EXPECT_EQ(statistics->compute().Figures().min_ns, 30);
  EXPECT_EQ(statistics->loop_delay().Figures().min_ns, 40);
  EXPECT_EQ(statistics->loop_delay().Figures().max_ns, 41);
  EXPECT_EQ(statistics->overruns(), 0);
}

TEST(TickStatisticsTest, CountsNoDelayForATickWithoutAForce) {
  const auto statistics = std::make_unique<TickStatistics>();
  statistics->Record({.wake_latency_ns = 10, .io_ns = 20, .compute_ns = 30, .loop_delay_ns = {}});
  EXPECT_EQ(statistics->loop_delay().Figures().count, 0);
  EXPECT_EQ(statistics->wake_latency().Figures().count, 1);
}

TEST(TickStatisticsTest, CountsALateWakeUpOnceHoweverManyTicksItCosts) {
  const auto statistics = std::make_unique<TickStatistics>();
  for (const uint64_t missed : {0U, 1U, 0U, 700U, 0U}) {
    statistics->Record({.loop_delay_ns = {}, .missed_ticks = missed});
  }
  EXPECT_EQ(statistics->overruns(), 2);
}

}  // namespace
}  // namespace mwidth::exchange
