// A running loop with every one of its crossings hammered at once; worth most under the thread sanitizer.

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <thread>

#include "server/exchange/clock.h"
#include "server/render/loop.h"
#include "tests/server/render/axis.h"

namespace mwidth::render {
namespace {

using exchange::State;

constexpr uint64_t kTicks = 20'000;
constexpr uint64_t kPosts = 2'000;
constexpr double kLargestMass = 0.4;

class SwingingDrive final : public device::Drive {
 public:
  device::DriveInfo Info() const noexcept override { return drive_.Info(); }
  device::Enabling Enable() noexcept override { return drive_.Enable(); }
  void Disable() noexcept override { drive_.Disable(); }
  device::Reading Read(uint64_t tick) noexcept override {
    drive_.position_counts = std::llround(1e5 * (1 - std::cos(0.012 * static_cast<double>(tick))));
    return drive_.Read(tick);
  }
  bool Write(int32_t force_counts) noexcept override { return drive_.Write(force_counts); }

 private:
  ScriptedDrive drive_;
};

class LoopConcurrencyTest : public testing::Test {
 protected:
  // What the gate does, faster and in any order.
  void PostAnything() {
    std::mt19937_64 random(17);  // NOLINT(cert-msc51-cpp): a fixed seed, so that a failure comes again
    std::uniform_real_distribution<double> mass(-kLargestMass, kLargestMass);
    exchange::Settings settings;
    settings.lease_deadline_ns = INT64_MAX;
    settings.filter = {.estimator = 0, .cutoff_hz = TestConfig().cutoff_hz};
    while (!over) {
      const uint64_t choice = random() % 100;
      settings.mass = mass(random);
      settings.ramp_s = 0.01;
      settings.rendering = choice >= 10;
      settings.render_epoch += choice < 60 ? 1 : 0;
      settings.emergency_stops += choice == 99 ? 1 : 0;
      settings.cleared_fault_number = choice < 90 ? newest_fault.load() : settings.cleared_fault_number;
      ++settings.sequence;
      crossing->settings.Post(settings);
      posts = settings.sequence;
      std::this_thread::yield();
    }
  }

  void FollowStatus() {
    exchange::LoopStatus status;
    uint64_t tick = 0;
    while (!over) {
      if (crossing->status.Take(status)) {
        EXPECT_GT(status.tick, tick) << "each status once, in order";
        tick = status.tick;
        EXPECT_LE(std::abs(status.mass), kLargestMass);
        newest_fault = status.fault.number;
        if (status.state == State::kRendering && status.mass != 0) {
          rendered = true;
        }
      }
      std::this_thread::yield();
    }
  }

  void FollowSamples() {
    exchange::Sample sample;
    uint64_t next = 1;
    uint64_t lost = 0;
    while (next <= kTicks || posts < kPosts || !rendered) {
      if (!crossing->samples.Pop(sample)) {
        std::this_thread::yield();
        continue;
      }
      ASSERT_GE(sample.tick, next);
      lost += sample.tick - next;
      next = sample.tick + 1;
    }
    // Read after the last sample: more may have been dropped since, none of these is missing from it.
    EXPECT_LE(lost, crossing->samples.dropped());
    over = true;
  }

  void ReadStatistics() {
    uint64_t last = 0;
    while (!over) {
      const exchange::DurationFigures figures = crossing->tick_statistics.compute().Figures();
      EXPECT_GE(figures.count, last);
      last = figures.count;
      std::this_thread::yield();
    }
  }

  std::unique_ptr<exchange::Crossing> crossing = std::make_unique<exchange::Crossing>();
  std::atomic<bool> over{false};
  std::atomic<bool> rendered{false};
  std::atomic<uint64_t> newest_fault{0};
  std::atomic<uint64_t> posts{0};
};

TEST_F(LoopConcurrencyTest, LosesNothingAndTearsNothingWhileAllOfItsCrossingsAreHammered) {
  SwingingDrive drive;
  exchange::SimulatedClock clock(100);
  Loop loop(drive, *crossing, clock, TestConfig());
  loop.Start();
  std::thread poster([this] { PostAnything(); });
  std::thread status([this] { FollowStatus(); });
  std::thread samples([this] { FollowSamples(); });
  std::thread statistics([this] { ReadStatistics(); });
  for (std::thread* thread : {&samples, &poster, &status, &statistics}) {
    thread->join();
  }
  exchange::LoopStatus end;
  while (end.settings_sequence < posts) {  // The newest settings reach the loop.
    crossing->status.Take(end);
  }
  loop.Stop();
  crossing->status.Take(end);
  EXPECT_GE(crossing->tick_statistics.wake_latency().Figures().count, kTicks);
  EXPECT_NE(end.state, State::kRendering);
}

}  // namespace
}  // namespace mwidth::render
