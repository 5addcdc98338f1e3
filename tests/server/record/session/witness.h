// What a recorder that is killed leaves in shared memory.
#pragma once

#include <atomic>
#include <cstdint>

namespace mwidth::record {

struct Witness {
  std::atomic<uint64_t> newest_tick = 0;
  /// When the thread that commits last began a step, and how much later than due one was at worst (ns).
  std::atomic<int64_t> step_ns = 0;
  std::atomic<int64_t> held_up_ns = 0;
};

}  // namespace mwidth::record
