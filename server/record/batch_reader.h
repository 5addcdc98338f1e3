// One subscriber's batches.
#pragma once

#include <cstddef>
#include <memory>

#include "server/record/batcher.h"
#include "server/record/broadcast.h"

namespace mwidth::record {

/// Pulls blocks from a subscription only as batches are asked for, so that what waits is bounded by the
/// subscription's queue. One thread at a time.
class BatchReader {
 public:
  BatchReader(std::unique_ptr<Subscription> subscription, Batcher batcher);

  /// Replaces `batch` by the next one: as many samples as are there now, up to the batcher's limit or a gap.
  /// Holds nothing back for a fuller batch. False when no selected sample is there; then `batch` means
  /// nothing.
  bool Next(Batch& batch);

  /// True when Next was false and will remain so: the broadcast is closed.
  bool ended() const { return subscription_->ended() && position_ == size(); }

 private:
  std::size_t size() const { return block_ == nullptr ? 0 : block_->size(); }

  std::unique_ptr<Subscription> subscription_;
  Batcher batcher_;
  // The block that is being cut, and how much of it is used up.
  std::shared_ptr<const SampleBlock> block_;
  std::size_t position_ = 0;
};

}  // namespace mwidth::record
