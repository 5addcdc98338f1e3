#include "server/render/loop.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/render/axis.h"

namespace mwidth::render {
namespace {

using exchange::Sample;
using exchange::State;

constexpr int64_t kPeriodNs = 1'000'000;

// Time that passes when the test says so: each sleep waits for a wake, which may come late.
class SteppedClock final : public exchange::Clock {
 public:
  int64_t NowNs() const noexcept override {
    const std::lock_guard lock(mutex_);
    return now_ns_;
  }
  void SleepUntilNs(int64_t deadline_ns) noexcept override {
    std::unique_lock lock(mutex_);
    asleep_ = true;
    changed_.notify_all();
    changed_.wait(lock, [this] { return wake_ || free_; });
    wake_ = asleep_ = false;
    now_ns_ = deadline_ns + late_ns_;
    deadlines_ns.push_back(deadline_ns);
  }
  /// Wakes the loop `late_ns` after its deadline, and returns when it sleeps again.
  void Wake(int64_t late_ns = 0) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return asleep_; });
    late_ns_ = late_ns;
    wake_ = true;
    asleep_ = false;
    changed_.notify_all();
    changed_.wait(lock, [this] { return asleep_; });
  }
  /// Never keeps the loop asleep again.
  void Free() {
    const std::lock_guard lock(mutex_);
    late_ns_ = 0;
    free_ = true;
    changed_.notify_all();
  }

  std::vector<int64_t> deadlines_ns;

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  int64_t now_ns_ = 5'000'000'000;
  int64_t late_ns_ = 0;
  bool asleep_ = false;
  bool wake_ = false;
  bool free_ = false;
};

class LoopTest : public testing::Test {
 protected:
  void Start() {
    loop = std::make_unique<Loop>(drive, *crossing, clock, TestConfig());
    report = loop->Start();
  }
  Sample Next(int64_t late_ns = 0) {
    clock.Wake(late_ns);
    Sample sample;
    EXPECT_TRUE(crossing->samples.Pop(sample));
    return sample;
  }
  void TearDown() override { clock.Free(); }

  ScriptedDrive drive;
  std::unique_ptr<exchange::Crossing> crossing = std::make_unique<exchange::Crossing>();
  SteppedClock clock;
  RealtimeReport report;
  std::unique_ptr<Loop> loop;
};

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

TEST_F(LoopTest, TellsHowLateItWokeUpAndHowOftenTooLate) {
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

TEST_F(LoopTest, TellsTheDelayOnlyWhereAForceWasWritten) {
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

TEST_F(LoopTest, AsksForWakefulCpusAsLongAsItRuns) {
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

TEST_F(LoopTest, LeavesIdleCpusAloneWhereNothingOrNotThisIsAskedOfTheHost) {
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
