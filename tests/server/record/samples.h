// Samples as a loop would leave them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "server/record/batcher.h"
#include "server/record/sample_sink.h"

namespace mwidth::record {

inline exchange::Sample SampleAt(uint64_t tick, uint64_t missed_ticks = 0) {
  exchange::Sample sample;
  sample.tick = tick;
  sample.missed_ticks = missed_ticks;
  return sample;
}

/// Samples of `count` ticks from `first_tick` on.
inline std::shared_ptr<const SampleBlock> BlockOf(uint64_t first_tick, std::size_t count,
                                                  uint64_t missed_ticks = 0) {
  auto block = std::make_shared<SampleBlock>();
  for (std::size_t i = 0; i < count; ++i) {
    block->push_back(SampleAt(first_tick + i, missed_ticks));
  }
  return block;
}

/// An encoding that a test can read: the ticks, each behind a space.
inline std::string EncodeTicks(const Batch& batch) {
  std::string ticks;
  for (const exchange::Sample& sample : batch.samples) {
    ticks += " " + std::to_string(sample.tick);
  }
  return ticks;
}

}  // namespace mwidth::record
