// Fans the samples of one axis out to subscribers in batches that they share; a slow one loses samples, and
// learns how many.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "server/record/batcher.h"
#include "server/record/sample_sink.h"
#include "server/record/subscriber_queue.h"

namespace mwidth::record {

struct BroadcastLimits {
  /// Above 0.
  std::size_t max_subscribers = 64;
  /// Most samples, as they are sent, that wait for one subscriber; above 0. One batch larger than this is
  /// taken by an empty queue.
  std::size_t max_queued_samples = 10'000;
};

class Subscription;

/// Cuts and encodes each batch once for all subscribers of equal cuts. Where batches are held back until they
/// are full, subscribers form groups of kGroupSize whose batches end at different times, so that a thousand
/// of them are not all written to at once. Consume never waits for a subscriber: a batch that does not fit
/// into its queue is dropped for it alone, and counted. Outlives its subscriptions.
class Broadcast final : public SampleSink {
 public:
  static constexpr std::size_t kGroupSize = 64;
  /// What a batch spans at least if its subscriber does not mind a few milliseconds: 0.1 s at 1 kHz.
  static constexpr std::size_t kPatientTicks = 100;

  explicit Broadcast(Encode encode, BroadcastLimits limits = {});
  ~Broadcast() override;

  /// A subscription to the samples from `first_tick` on, or nullptr where there are max_subscribers already.
  /// Its first batch ends with that of its group, and so may be shorter than min_batch. Throws
  /// std::invalid_argument for a cut out of range.
  ///
  /// `notify` is called after batches were queued, and after Close; it may come late, so that nothing is left
  /// to take, but never too early. It runs on the thread of Consume or Close, returns soon, does not throw,
  /// and may destroy the subscription. It can run before Subscribe returns. Any thread.
  std::unique_ptr<Subscription> Subscribe(const Cut& cut, uint64_t first_tick, std::function<void()> notify);

  void Consume(std::shared_ptr<const SampleBlock> block) override;

  /// Whether the batches of any subscriber may be shorter than kPatientTicks.
  bool eager() const override;

  /// Hands out what was held back and ends every subscription, once what it has queued is taken. Any thread,
  /// when nobody consumes any more.
  void Close();

  /// Subscriptions that exist. Any thread.
  std::size_t subscribers() const;
  /// Different batches that are made of one and the same samples. Any thread.
  std::size_t groups() const;
  const BroadcastLimits& limits() const { return limits_; }

 private:
  friend class Subscription;
  class Group;
  using Groups = std::vector<std::shared_ptr<Group>>;

  std::shared_ptr<Group> FindGroup(const Cut& cut) const;
  std::size_t FreePhase(const Cut& cut) const;
  Groups AllGroups() const;
  void Remove(const SubscriberQueue* queue);

  const Encode encode_;
  const BroadcastLimits limits_;
  // One subscription at a time, so that none waits for mutex_ while another computes its filter.
  std::mutex subscribe_mutex_;
  mutable std::mutex mutex_;
  bool closed_ = false;
  std::size_t subscribers_ = 0;
  Groups groups_;
};

/// One subscriber's end. Any thread.
class Subscription {
 public:
  Subscription(const Subscription&) = delete;
  Subscription& operator=(const Subscription&) = delete;
  /// Unsubscribes. Afterwards no notification runs: one that runs on another thread is waited for, one that
  /// this call comes from is its last. Hold no lock that `notify` takes.
  ~Subscription();

  /// Replaces `delivery` by what waits, up to max_batch samples or a gap. False where nothing does; then
  /// `delivery` means nothing.
  bool Take(Delivery& delivery) { return queue_->Take(delivery); }
  /// True when the broadcast is closed and everything is taken: nothing will follow.
  bool ended() const { return queue_->ended(); }

 private:
  friend class Broadcast;
  Subscription(Broadcast& broadcast, std::shared_ptr<SubscriberQueue> queue);

  Broadcast& broadcast_;
  std::shared_ptr<SubscriberQueue> queue_;
};

}  // namespace mwidth::record
