// A loop on a thread of its own, with time that passes when the test says so.
#pragma once

#include <gtest/gtest.h>

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "server/render/loop.h"
#include "tests/server/render/axis.h"

namespace mwidth::render {

inline constexpr int64_t kPeriodNs = 1'000'000;

/// Time that passes when the test says so: each sleep waits for a wake, which may come late.
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
  exchange::Sample Next(int64_t late_ns = 0) {
    clock.Wake(late_ns);
    exchange::Sample sample;
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

}  // namespace mwidth::render
