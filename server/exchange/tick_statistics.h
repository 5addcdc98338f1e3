// How punctual a loop is: what each tick took, gathered by the loop, read by anyone at any time.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "server/exchange/histogram.h"

namespace mwidth::exchange {

/// The durations of one tick, by the clock of its axis: on a simulated clock, which stands still while the
/// loop works, they are 0.
struct TickTimes {
  /// From the deadline that was slept for to the wake-up.
  int64_t wake_latency_ns = 0;
  /// In calls of the drive.
  int64_t io_ns = 0;
  /// From the wake-up to the end of the tick, without those calls.
  int64_t compute_ns = 0;
  /// From before the position was asked for until the drive had taken the force: a bound on the delay of the
  /// loop as far as the host sees it. None where the drive did not answer or no force was written.
  std::optional<int64_t> loop_delay_ns;
  /// Deadlines missed by this wake-up, besides the one that it was for.
  uint64_t missed_ticks = 0;
};

/// All of it since the loop began; never reset. The loop records, any thread reads.
class TickStatistics {
 public:
  /// Writer only. Rt.
  void Record(const TickTimes& times) noexcept {
    wake_latency_.Record(times.wake_latency_ns);
    io_.Record(times.io_ns);
    compute_.Record(times.compute_ns);
    if (times.loop_delay_ns) {
      loop_delay_.Record(*times.loop_delay_ns);
    }
    if (times.missed_ticks > 0) {
      overruns_.store(overruns_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    }
  }

  const DurationHistogram& wake_latency() const noexcept { return wake_latency_; }
  const DurationHistogram& io() const noexcept { return io_; }
  const DurationHistogram& compute() const noexcept { return compute_; }
  const DurationHistogram& loop_delay() const noexcept { return loop_delay_; }
  /// How often the loop woke up a whole period late or more, however many ticks that cost.
  uint64_t overruns() const noexcept { return overruns_.load(std::memory_order_relaxed); }

 private:
  DurationHistogram wake_latency_;
  DurationHistogram io_;
  DurationHistogram compute_;
  DurationHistogram loop_delay_;
  std::atomic<uint64_t> overruns_{0};
};

}  // namespace mwidth::exchange
