// What waits for one subscriber, and what it has lost.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "server/record/batcher.h"
#include "server/record/notification.h"

namespace mwidth::record {

/// A batch as it is sent, made once and shared by whoever gets it.
struct EncodedBatch {
  uint64_t first_tick = 0;
  uint32_t decimation = 1;
  std::size_t samples = 0;
  uint64_t missed_ticks_before = 0;
  uint64_t dropped_ticks_before = 0;
  std::string bytes;
};

/// Turns a batch, which has samples, into the bytes that are sent.
using Encode = std::function<std::string(const Batch&)>;

std::shared_ptr<const EncodedBatch> MakeEncoded(const Batch& batch, const Encode& encode);

/// What one subscriber takes at once: batches without a gap between them, together one batch.
struct Delivery {
  std::vector<std::shared_ptr<const EncodedBatch>> batches;
  /// Before the first of them, what this subscriber alone lost included.
  uint64_t missed_ticks_before = 0;
  uint64_t dropped_ticks_before = 0;

  uint64_t first_tick() const { return batches.front()->first_tick; }
  std::size_t samples() const;
  /// True where the bytes of the one batch say it all.
  bool as_encoded() const;
};

/// Bounded; never waits. Shared by the broadcast and the subscription, as its notification is. Any thread,
/// but for the two functions of the broadcast's.
class SubscriberQueue {
 public:
  struct Terms {
    /// Ticks before this one are passed over.
    uint64_t first_tick = 0;
    /// Most samples of a delivery.
    std::size_t max_batch = 1;
    /// Most samples that wait.
    std::size_t max_samples = 1;
  };

  SubscriberQueue(const Terms& terms, std::function<void()> notify, bool closed);

  /// Index of the first sample of `batch` that this subscriber is to get. By the broadcast, until begun.
  std::size_t FirstSampleOf(const Batch& batch) const;
  /// Whether a batch was offered. By the broadcast.
  bool begun() const { return begun_; }

  /// Queues a batch where it fits or nothing waits; counts it as lost otherwise. By the broadcast.
  void Offer(const std::shared_ptr<const EncodedBatch>& batch);
  /// Calls `notify` unless detached.
  void Notify() { notification_.Notify(); }
  /// Moves the oldest batches into `delivery`: as many as make one batch. False where none waits.
  bool Take(Delivery& delivery);
  /// Nothing will be offered any more.
  void Close();
  /// True when closed and everything is taken.
  bool ended() const;
  /// Afterwards no notification runs: waits for one that runs on another thread.
  void Detach() { notification_.Detach(); }

 private:
  struct Waiting {
    std::shared_ptr<const EncodedBatch> batch;
    // Ticks before the batch that this subscriber alone lost.
    uint64_t missed_before = 0;
    uint64_t dropped_before = 0;

    bool AfterAGap() const;
  };

  const Terms terms_;
  Notification notification_;
  bool begun_ = false;

  mutable std::mutex mutex_;
  std::deque<Waiting> waiting_;
  std::size_t waiting_samples_ = 0;
  // Lost since the newest batch that waits or was taken.
  uint64_t missed_ = 0;
  uint64_t dropped_ = 0;
  bool closed_;
};

}  // namespace mwidth::record
