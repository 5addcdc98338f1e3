// What a loop tells of its punctuality, and asks of the host while it runs.

#include <gtest/gtest.h>
#include <sys/mman.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>

#include "server/exchange/clock.h"
#include "server/render/cpu_latency.h"
#include "tests/server/render/loop_fixture.h"

namespace mwidth::render {
namespace {

using LoopHostTest = LoopTest;

TEST_F(LoopHostTest, TellsHowLateItWokeUpAndHowOftenTooLate) {
  Start();
  Next(200);
  Next(300);
  Next(3 * kPeriodNs + 5);
  Next(kPeriodNs - 1);
  const exchange::DurationFigures lag = crossing->tick_statistics.wake_latency().Figures();
  EXPECT_EQ(lag.count, 4);
  EXPECT_EQ(lag.min_ns, 200);
  EXPECT_EQ(lag.max_ns, 3 * kPeriodNs + 5);
  EXPECT_EQ(crossing->tick_statistics.overruns(), 1);
}

TEST_F(LoopHostTest, TellsTheDelayOnlyWhereAForceWasWritten) {
  Start();
  Next();
  EXPECT_EQ(crossing->tick_statistics.io().Figures().count, 1);
  EXPECT_EQ(crossing->tick_statistics.loop_delay().Figures().count, 0) << "the drive is not enabled";
  exchange::Settings settings{.sequence = 1, .rendering = true, .render_epoch = 1};
  settings.lease_deadline_ns = INT64_MAX;
  crossing->settings.Post(settings);
  Next();
  EXPECT_EQ(crossing->tick_statistics.loop_delay().Figures().count, 1);
}

// How often this process has the kernel's latency device open.
int OpenLatencyRequests() {
  int requests = 0;
  for (const auto& file : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code gone;
    requests += std::filesystem::read_symlink(file, gone) == "/dev/cpu_dma_latency" ? 1 : 0;
  }
  return requests;
}

TEST_F(LoopHostTest, AsksForWakefulCpusAsLongAsItRuns) {
  const bool has_device = CpuLatencyRequest().refusal().empty();
  LoopConfig config = TestConfig();
  config.realtime.priority = 1;
  loop = std::make_unique<Loop>(drive, *crossing, clock, config);
  report = loop->Start();
  EXPECT_EQ(OpenLatencyRequests(), has_device ? 1 : 0);
  EXPECT_EQ(report.message.find("/dev/cpu_dma_latency") == std::string::npos, has_device) << report.message;
  clock.Free();
  loop->Stop();
  EXPECT_EQ(OpenLatencyRequests(), 0);
  munlockall();
}

TEST_F(LoopHostTest, LeavesIdleCpusAloneWhereNothingOrNotThisIsAskedOfTheHost) {
  LoopConfig config = TestConfig();
  config.realtime.allow_deep_idle = true;
  for (const int priority : {0, 1}) {
    config.realtime.priority = priority;
    exchange::SimulatedClock simulated(1000);
    Loop other(drive, *crossing, simulated, config);
    other.Start();
    EXPECT_EQ(OpenLatencyRequests(), 0) << priority;
  }
  munlockall();
}

}  // namespace
}  // namespace mwidth::render
