// What the drain hands on, and to whom.
#pragma once

#include <memory>
#include <vector>

#include "server/exchange/crossing.h"

namespace mwidth::record {

/// Samples of one axis in the order of their ticks, as the drain found them. Ticks rise strictly; where they
/// rise by more than one, ticks were missed by the loop or dropped by a full ring.
using SampleBlock = std::vector<exchange::Sample>;

/// One user of an axis's samples: the broadcast, or the session recorder.
class SampleSink {
 public:
  SampleSink() = default;
  SampleSink(const SampleSink&) = delete;
  SampleSink& operator=(const SampleSink&) = delete;
  virtual ~SampleSink() = default;

  /// Takes a share of the next block, which is not empty and never changes again. Returns soon: while it
  /// runs, the samples of every other sink wait in the ring. Does not throw. Called by the drain's thread.
  virtual void Consume(std::shared_ptr<const SampleBlock> block) = 0;

  /// True where somebody waits for the next sample rather than for many: the drain then looks twice as often.
  /// Called by the drain's thread.
  virtual bool eager() const { return false; }
};

}  // namespace mwidth::record
