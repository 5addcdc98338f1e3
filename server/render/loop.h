// The thread that ticks.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <thread>

#include "device/drive.h"
#include "server/exchange/clock.h"
#include "server/exchange/crossing.h"
#include "server/render/cpu_latency.h"
#include "server/render/loop_config.h"
#include "server/render/realtime.h"
#include "server/render/tick.h"
#include "server/render/timed_drive.h"

namespace mwidth::render {

/// Runs one axis's tick at absolute deadlines, one period apart. A deadline that was missed by whole periods
/// is skipped: the tick's number jumps, the missed ticks are counted, and nothing is ever replayed in a
/// burst, which would show the estimator positions of one moment as if they were of many. Start and Stop are
/// called by one thread, each once.
class Loop {
 public:
  /// The axis's drive, crossing and clock must outlive the loop. Throws std::invalid_argument, with the field
  /// and what is allowed, for a config that is out of range.
  Loop(device::Drive& drive, exchange::Crossing& crossing, exchange::Clock& clock, const LoopConfig& config);
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;
  /// Stops.
  ~Loop();

  /// Begins to tick, in IDLE, and says what the host granted. Throws std::system_error if there is no thread
  /// to have.
  RealtimeReport Start();
  /// Begins what Stop does, without waiting for it: several loops can end at the same time. Any thread.
  void BeginStop() noexcept { stopping_.store(true, std::memory_order_relaxed); }
  /// Ramps what is rendered to zero (0.2 s of the clock), disables the drive and ends the thread.
  void Stop() noexcept;

 private:
  void Run() noexcept;

  /// Records what the tick took that woke up at `now_ns`, `wake_latency_ns` after its deadline.
  void RecordTimes(int64_t now_ns, int64_t wake_latency_ns, uint64_t missed_ticks) noexcept;

  exchange::Clock& clock_;
  exchange::TickStatistics& statistics_;
  const LoopConfig config_;
  TimedDrive drive_;
  Tick tick_;
  std::optional<CpuLatencyRequest> cpu_latency_;
  RealtimeReport report_;
  std::atomic<bool> reported_{false};
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace mwidth::render
