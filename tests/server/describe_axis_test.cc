#include "server/describe_axis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mwidth::server {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const render::RealtimeReport kGranted{.realtime = true, .message = "SCHED_FIFO priority 80"};
const render::RealtimeReport kRefused{.realtime = false,
                                      .message = "memory is not locked: grant CAP_IPC_LOCK"};

TEST(DescribeAxisTest, TellsTheGateWhatDelayTheWatchTolerates) {
  AxisConfig config;
  config.loop.delay_s = 1e-3;
  config.watch.delay_limit_s = 1.25e-3;
  EXPECT_NEAR(DescribeAxis(config).Requirements().delay_tolerance_s, 2.5e-4, 1e-18);
}

TEST(RenderingBlockedReasonTest, BlocksARealDriveOnAHostThatRefusesAndSaysWhatToDo) {
  EXPECT_THAT(
      RenderingBlockedReason(false, kRefused, false),
      AllOf(HasSubstr(kRefused.message), HasSubstr("mwidthd doctor"), HasSubstr("--allow-non-realtime")));
}

TEST(RenderingBlockedReasonTest, LetsARealDriveRenderWhereTheHostGrantsAllOrTheOperatorAllowsIt) {
  EXPECT_EQ(RenderingBlockedReason(false, kGranted, false), "");
  EXPECT_EQ(RenderingBlockedReason(false, kRefused, true), "");
}

TEST(RenderingBlockedReasonTest, LetsASimulatedDriveRenderAnywhere) {
  EXPECT_EQ(RenderingBlockedReason(true, kRefused, false), "");
}

}  // namespace
}  // namespace mwidth::server
