// Fans the blocks of one axis out to subscribers; a slow one loses samples, and learns how many.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "server/record/sample_sink.h"

namespace mwidth::record {

struct BroadcastLimits {
  /// Above 0.
  std::size_t max_subscribers = 64;
  /// Most samples that wait for one subscriber; above 0. One block larger than this is taken by an empty
  /// queue.
  std::size_t max_queued_samples = 10'000;
};

/// A block as one subscriber gets it.
struct Delivery {
  /// Samples that this subscriber lost directly before the block, because its queue was full.
  uint64_t dropped_before = 0;
  std::shared_ptr<const SampleBlock> block;
};

class Subscription;

/// Copies nothing: subscribers share the blocks. Consume never waits for a subscriber: a block that does not
/// fit into its queue is dropped for it alone, and counted. Outlives its subscriptions.
class Broadcast final : public SampleSink {
 public:
  explicit Broadcast(BroadcastLimits limits = {});
  ~Broadcast() override;

  /// A subscription to the blocks consumed from now on, or nullptr where there are max_subscribers already or
  /// the broadcast is closed. `notify` is called after a block was queued, and after Close; it may come late,
  /// so that nothing is left to take, but never too early. It runs on the thread of Consume or Close, returns
  /// soon, does not throw, and may destroy the subscription. It can run before Subscribe returns. Any thread.
  std::unique_ptr<Subscription> Subscribe(std::function<void()> notify);

  void Consume(std::shared_ptr<const SampleBlock> block) override;

  /// Ends every subscription, once what it has queued is taken. Any thread, when nobody consumes any more.
  void Close();

  /// Subscriptions that exist. Any thread.
  std::size_t subscribers() const;
  const BroadcastLimits& limits() const { return limits_; }

 private:
  friend class Subscription;
  class Queue;

  std::vector<std::shared_ptr<Queue>> Queues() const;
  void Remove(const Queue* queue);

  const BroadcastLimits limits_;
  mutable std::mutex mutex_;
  bool closed_ = false;
  std::vector<std::shared_ptr<Queue>> queues_;
};

/// One subscriber's end.
class Subscription {
 public:
  Subscription(const Subscription&) = delete;
  Subscription& operator=(const Subscription&) = delete;
  /// Unsubscribes. Afterwards no notification runs: one that runs on another thread is waited for, one that
  /// this call comes from is its last. Hold no lock that `notify` takes.
  ~Subscription();

  /// The oldest block not taken yet, if any. Any thread.
  std::optional<Delivery> Take();
  /// True when the broadcast is closed and everything is taken: no block will follow. Any thread.
  bool ended() const;

 private:
  friend class Broadcast;
  Subscription(Broadcast& broadcast, std::shared_ptr<Broadcast::Queue> queue);

  Broadcast& broadcast_;
  std::shared_ptr<Broadcast::Queue> queue_;
};

}  // namespace mwidth::record
