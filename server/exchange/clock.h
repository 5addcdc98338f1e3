// The server's monotonic time, injected so that tests and simulations choose how it passes.
#pragma once

#include <atomic>
#include <cstdint>

namespace mwidth::exchange {

/// Monotonic time of one axis: its loop, its lease and its samples all count on the same clock.
/// Both functions may be called from any thread; SleepUntilNs only by the loop.
class Clock {
 public:
  Clock() = default;
  Clock(const Clock&) = delete;
  Clock& operator=(const Clock&) = delete;
  virtual ~Clock() = default;

  /// Nanoseconds since an arbitrary start. Rt: no allocation, lock or exception.
  virtual int64_t NowNs() const noexcept = 0;
  /// Returns at or after `deadline_ns`. Rt.
  virtual void SleepUntilNs(int64_t deadline_ns) noexcept = 0;
};

/// CLOCK_MONOTONIC, which no setting of the wall clock moves.
class MonotonicClock final : public Clock {
 public:
  /// The last `spin_ns` (0 or more) before a deadline are polled instead of slept through: they cost CPU time
  /// and spare the wake-up.
  explicit MonotonicClock(int64_t spin_ns = 0) noexcept : spin_ns_(spin_ns) {}
  int64_t NowNs() const noexcept override;
  void SleepUntilNs(int64_t deadline_ns) noexcept override;

 private:
  int64_t spin_ns_;
};

/// Time that passes only as the loop sleeps, `speed` times as fast as real time: a simulated axis never
/// misses a deadline on it, however the host stalls, and a recording plays in a fraction of its length.
class SimulatedClock final : public Clock {
 public:
  /// `speed` above 0.
  explicit SimulatedClock(double speed);
  int64_t NowNs() const noexcept override;
  void SleepUntilNs(int64_t deadline_ns) noexcept override;

 private:
  MonotonicClock real_;
  double speed_;
  std::atomic<int64_t> now_ns_;
  // Real time and simulated time that correspond; moved forward when the host falls behind.
  int64_t real_origin_ns_;
  int64_t origin_ns_;
};

}  // namespace mwidth::exchange
