// A clock that keeps a record of the thread that sleeps on it.
#pragma once

#include <atomic>
#include <cstdint>

#include "server/exchange/clock.h"
#include "server/exchange/histogram.h"

namespace mwidth::bench {

/// What a thread has cost and suffered so far.
struct ThreadUsage {
  int64_t cpu_ns = 0;
  int64_t page_faults = 0;
  int64_t involuntary_switches = 0;
  uint64_t heap_calls = 0;
};

/// What happened to the sleeper while it was watched.
struct Watched {
  exchange::DurationFigures lag;
  uint64_t ticks = 0;
  /// Periods in which it did not wake.
  uint64_t missed = 0;
  /// Between the first and the last of those ticks.
  ThreadUsage usage;

  double CpuPerTickNs() const { return static_cast<double>(usage.cpu_ns) / static_cast<double>(ticks); }
};

/// CLOCK_MONOTONIC. The same few instructions watch the bare loop and the whole one, so that they cost both
/// the same. Watch is called once, by another thread than the sleeper.
class WatchedClock final : public exchange::Clock {
 public:
  explicit WatchedClock(int64_t period_ns, int64_t spin_ns = 0) noexcept
      : clock_(spin_ns), period_ns_(period_ns) {}

  int64_t NowNs() const noexcept override { return clock_.NowNs(); }
  void SleepUntilNs(int64_t deadline_ns) noexcept override;

  /// Lets the sleeper run for `duration_s` and tells what happened to it.
  Watched Watch(double duration_s);
  /// The deadline that is slept for, or was last; 0 before the first.
  int64_t deadline_ns() const noexcept { return deadline_ns_.load(std::memory_order_relaxed); }

 private:
  enum class Phase : uint8_t { kBefore, kDuring, kEnd, kAfter };

  exchange::MonotonicClock clock_;
  const int64_t period_ns_;
  std::atomic<int64_t> deadline_ns_{0};
  std::atomic<Phase> phase_{Phase::kBefore};
  exchange::DurationHistogram lag_;
  // The sleeper's alone until phase_ is kAfter.
  bool begun_ = false;
  ThreadUsage first_;
  int64_t first_deadline_ns_ = 0;
  Watched watched_;
};

}  // namespace mwidth::bench
