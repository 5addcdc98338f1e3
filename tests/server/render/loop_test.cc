#include "server/render/loop.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/render/loop_fixture.h"

namespace mwidth::render {
namespace {

using exchange::Sample;
using exchange::State;

TEST_F(LoopTest, TicksAtAbsoluteDeadlinesHoweverLateEachWakeIs) {
  Start();
  for (int64_t k = 1; k <= 20; ++k) {
    const int64_t late_ns = k % 2 == 0 ? kPeriodNs - 1 : 0;
    const Sample sample = Next(late_ns);
    EXPECT_EQ(sample.tick, k);
    EXPECT_EQ(sample.missed_ticks, 0);
    EXPECT_EQ(sample.monotonic_ns, 5'000'000'000 + k * kPeriodNs + late_ns);
  }
}

TEST_F(LoopTest, SkipsAndCountsMissedDeadlinesAndNeverReplaysThem) {
  Start();
  Next();
  Next();
  const Sample late = Next(3 * kPeriodNs + kPeriodNs / 2);
  EXPECT_EQ(late.tick, 6);
  EXPECT_EQ(late.missed_ticks, 3);
  const Sample after = Next();
  EXPECT_EQ(after.tick, 7);
  EXPECT_EQ(after.missed_ticks, 3);
  EXPECT_EQ(after.monotonic_ns, 5'000'000'000 + 7 * kPeriodNs);
  EXPECT_EQ(Next(kPeriodNs).tick, 9);
}

TEST_F(LoopTest, BeginsToStopWithoutBeingWaitedFor) {
  Start();
  exchange::Settings settings{.sequence = 1, .rendering = true, .render_epoch = 1, .mass = 0.1, .ramp_s = 0};
  settings.lease_deadline_ns = INT64_MAX;
  settings.filter = {.estimator = 0, .cutoff_hz = TestConfig().cutoff_hz};
  crossing->settings.Post(settings);
  Next();
  EXPECT_EQ(Next().mass, 0.1);
  loop->BeginStop();
  Next();
  const Sample ramping = Next();
  EXPECT_LT(ramping.mass, 0.1);
  EXPECT_GT(ramping.mass, 0);
}

TEST_F(LoopTest, RampsDownAndDisablesTheDriveWhenItStops) {
  Start();
  crossing->settings.Post({.sequence = 1,
                           .rendering = true,
                           .render_epoch = 1,
                           .mass = 0.5,
                           .ramp_s = 0,
                           .lease_deadline_ns = std::numeric_limits<int64_t>::max()});
  EXPECT_EQ(Next().state, State::kRendering);
  EXPECT_EQ(Next().mass, 0.5);
  std::thread stopper([this] { loop->Stop(); });
  double last_mass = 0.5;
  uint64_t ramp_ticks = 0;
  const auto follow = [&](const Sample& sample) {
    EXPECT_LE(sample.mass, last_mass);
    ramp_ticks += sample.mass < last_mass ? 1 : 0;
    last_mass = sample.mass;
  };
  // Tick by tick until the loop knows of the stop; the rest of the ramp fits into the ring.
  while (ramp_ticks == 0) {
    follow(Next());
  }
  clock.Free();
  stopper.join();
  for (Sample sample; crossing->samples.Pop(sample);) {
    follow(sample);
  }
  EXPECT_EQ(ramp_ticks, 200);
  EXPECT_EQ(last_mass, 0);
  EXPECT_FALSE(drive.enabled);
  exchange::LoopStatus status;
  ASSERT_TRUE(crossing->status.Take(status));
  EXPECT_EQ(status.state, State::kIdle);
  EXPECT_EQ(status.renderings_ended, 1);
}

TEST_F(LoopTest, DisablesTheDriveWhenItIsDestroyed) {
  Start();
  clock.Free();
  loop.reset();
  EXPECT_GE(drive.disables, 1);
}

TEST_F(LoopTest, ReportsThatRealTimeWasNotAskedFor) {
  Start();
  EXPECT_FALSE(report.realtime);
  EXPECT_THAT(report.message, testing::HasSubstr("not asked for"));
}

TEST_F(LoopTest, NeverMissesATickOnASimulatedClock) {
  exchange::SimulatedClock simulated(1e6);
  Loop fast(drive, *crossing, simulated, TestConfig());
  fast.Start();
  Sample sample;
  for (uint64_t last = 0; last < 3000;) {
    if (crossing->samples.Pop(sample)) {
      ASSERT_EQ(sample.missed_ticks, 0);
      ASSERT_GT(sample.tick, last);
      last = sample.tick;
    }
  }
  fast.Stop();
}

TEST(LoopConstructorTest, RefusesWhatCannotRun) {
  ScriptedDrive drive;
  drive.info.force_quantum = 0;
  const auto crossing = std::make_unique<exchange::Crossing>();
  exchange::SimulatedClock clock(1);
  EXPECT_THROW(Loop(drive, *crossing, clock, TestConfig()), std::invalid_argument);
}

}  // namespace
}  // namespace mwidth::render
