// Empties the ring that the loop fills, and hands what it finds to the sinks.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

#include "server/exchange/crossing.h"
#include "server/record/sample_sink.h"

namespace mwidth::record {

using SampleRing = exchange::Ring<exchange::Sample, exchange::kSampleRingCapacity>;

/// The one reader of an axis's ring. The loop never wakes it: it looks by itself, once a period, so that a
/// tick costs no system call and a block carries the samples of a period at once.
class Drain {
 public:
  /// A block holds at most so many samples, however long the drain was held up.
  static constexpr std::size_t kMaxBlockSamples = 512;

  /// Delivers to `sinks` in their order; ring and sinks outlive the drain. `eager_period`, or twice of it
  /// while no sink is eager, bounds what the drain adds to a sample's age; above 0, and well below the time
  /// in which the loop fills the ring (0.4 s at 10 kHz). Throws std::invalid_argument for one that is not
  /// above 0.
  Drain(SampleRing& ring, std::vector<SampleSink*> sinks, std::chrono::microseconds eager_period);
  Drain(const Drain&) = delete;
  Drain& operator=(const Drain&) = delete;
  /// Stops.
  ~Drain();

  /// Starts the thread. Precondition: not running.
  void Start();
  /// Ends the thread and delivers what is left in the ring; stop the loop first to lose nothing. Does no harm
  /// twice.
  void Stop();

  /// Delivers what is in the ring now, and returns how many samples that were. By the thread, or by any one
  /// caller while no thread runs.
  std::size_t DrainOnce();

  /// How long it now waits before it looks again. By the thread, or while none runs.
  std::chrono::microseconds period() const;

  /// Samples that the loop dropped since the start because the ring was full. Any thread.
  uint64_t dropped() const { return ring_.dropped(); }

 private:
  void Run(const std::stop_token& stop);

  SampleRing& ring_;
  const std::vector<SampleSink*> sinks_;
  const std::chrono::microseconds eager_period_;
  std::mutex mutex_;
  std::condition_variable_any stopping_;
  std::jthread thread_;
};

}  // namespace mwidth::record
