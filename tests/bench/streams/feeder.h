// A loop that costs nothing: samples of a slow reach, 1000 a second.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>

#include "server/exchange/crossing.h"

namespace mwidth::bench {

/// What a tick leaves behind, as full as those of an axis that renders.
exchange::Sample SampleOf(uint64_t tick, int64_t monotonic_ns);

/// Calls `take` every millisecond, on a thread of its own whose CPU time can be told apart.
class Feeder {
 public:
  explicit Feeder(std::function<void(const exchange::Sample&)> take);
  Feeder(const Feeder&) = delete;
  Feeder& operator=(const Feeder&) = delete;
  ~Feeder();

  /// CPU time of the thread so far, `take` included.
  double CpuS() const;

 private:
  void Run();

  const std::function<void(const exchange::Sample&)> take_;
  std::atomic<bool> over_ = false;
  std::thread thread_;
};

}  // namespace mwidth::bench
