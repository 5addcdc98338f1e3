#include "server/rpc/convert_statistics.h"

#include <gtest/gtest.h>

#include <memory>

namespace mwidth::rpc {
namespace {

TEST(ConvertStatisticsTest, TellsEveryDurationInSeconds) {
  const auto statistics = std::make_unique<exchange::TickStatistics>();
  for (int64_t i = 1; i <= 100; ++i) {
    statistics->Record({.wake_latency_ns = i,
                        .io_ns = 10 * i,
                        .compute_ns = 50,
                        .loop_delay_ns = {},
                        .missed_ticks = i == 100 ? 3U : 0U});
  }
  v1::TickStatistics message;
  Convert(*statistics, message);
  EXPECT_EQ(message.wake_latency().count(), 100);
  EXPECT_DOUBLE_EQ(message.wake_latency().min_s(), 1e-9);
  EXPECT_DOUBLE_EQ(message.wake_latency().p50_s(), 50e-9);
  EXPECT_DOUBLE_EQ(message.wake_latency().p99_s(), 99e-9);
  EXPECT_DOUBLE_EQ(message.wake_latency().p999_s(), 100e-9);
  EXPECT_DOUBLE_EQ(message.wake_latency().max_s(), 100e-9);
  EXPECT_DOUBLE_EQ(message.io().max_s(), 1e-6);
  EXPECT_DOUBLE_EQ(message.compute().p50_s(), 50e-9);
  EXPECT_EQ(message.loop_delay().count(), 0);
  EXPECT_EQ(message.loop_delay().max_s(), 0);
  EXPECT_EQ(message.overruns(), 1);
}

}  // namespace
}  // namespace mwidth::rpc
