// The loop that does nothing: what the host gives any thread that sleeps until absolute deadlines.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <thread>

#include "server/render/realtime.h"
#include "tests/bench/loop/watched_clock.h"

namespace mwidth::bench {

/// Sleeps on `clock` from deadline to deadline, with the scheduling that render::Loop has, until it is
/// destroyed. Missed deadlines are skipped as render::Loop skips them.
class BareLoop {
 public:
  /// Deadlines lie at `first_deadline_ns` plus multiples of the period.
  BareLoop(WatchedClock& clock, int64_t first_deadline_ns, int64_t period_ns,
           const render::RealtimeConfig& realtime)
      : thread_([this, &clock, first_deadline_ns, period_ns, realtime] {
          render::EnterRealtime(realtime);
          for (int64_t deadline_ns = first_deadline_ns; !ending_.load(std::memory_order_relaxed);
               deadline_ns += period_ns) {
            clock.SleepUntilNs(deadline_ns);
            const int64_t late_ns = std::max<int64_t>(0, clock.NowNs() - deadline_ns);
            deadline_ns += late_ns / period_ns * period_ns;
          }
        }) {}
  BareLoop(const BareLoop&) = delete;
  BareLoop& operator=(const BareLoop&) = delete;
  ~BareLoop() {
    ending_.store(true, std::memory_order_relaxed);
    thread_.join();
  }

 private:
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace mwidth::bench
