#include "server/record/broadcast.h"

#include <algorithm>
#include <deque>
#include <utility>

namespace mwidth::record {

/// What waits for one subscriber. Shared by the broadcast and the subscription, so that it outlives a
/// notification in which the subscription is destroyed.
class Broadcast::Queue {
 public:
  Queue(std::size_t max_samples, std::function<void()> notify, bool closed)
      : max_samples_(max_samples), notify_(std::move(notify)), closed_(closed) {}

  void Offer(const std::shared_ptr<const SampleBlock>& block) {
    {
      const std::lock_guard lock(mutex_);
      // The oldest stay: what is delivered is then contiguous for as long as possible, with one gap behind
      // it.
      if (!deliveries_.empty() && queued_samples_ + block->size() > max_samples_) {
        dropped_ += block->size();
        return;
      }
      deliveries_.push_back({.dropped_before = std::exchange(dropped_, 0), .block = block});
      queued_samples_ += block->size();
    }
    Notify();
  }

  std::optional<Delivery> Take() {
    const std::lock_guard lock(mutex_);
    if (deliveries_.empty()) {
      return std::nullopt;
    }
    Delivery delivery = std::move(deliveries_.front());
    deliveries_.pop_front();
    queued_samples_ -= delivery.block->size();
    return delivery;
  }

  void Close() {
    {
      const std::lock_guard lock(mutex_);
      closed_ = true;
    }
    Notify();
  }

  bool ended() const {
    const std::lock_guard lock(mutex_);
    return closed_ && deliveries_.empty();
  }

  void Detach() {
    const std::lock_guard running(notify_mutex_);
    detached_ = true;
  }

 private:
  void Notify() {
    const std::lock_guard running(notify_mutex_);
    if (!detached_) {
      notify_();
    }
  }

  const std::size_t max_samples_;
  const std::function<void()> notify_;
  // Held while a notification runs: Detach waits for it. Recursive, because a notification may detach itself.
  std::recursive_mutex notify_mutex_;
  bool detached_ = false;

  mutable std::mutex mutex_;
  std::deque<Delivery> deliveries_;
  std::size_t queued_samples_ = 0;
  uint64_t dropped_ = 0;
  bool closed_;
};

Broadcast::Broadcast(BroadcastLimits limits) : limits_(limits) {}

Broadcast::~Broadcast() = default;

std::unique_ptr<Subscription> Broadcast::Subscribe(std::function<void()> notify) {
  const std::lock_guard lock(mutex_);
  if (queues_.size() >= limits_.max_subscribers) {
    return nullptr;
  }
  auto queue = std::make_shared<Queue>(limits_.max_queued_samples, std::move(notify), closed_);
  queues_.push_back(queue);
  return std::unique_ptr<Subscription>(new Subscription(*this, std::move(queue)));
}

void Broadcast::Consume(std::shared_ptr<const SampleBlock> block) {
  for (const auto& queue : Queues()) {
    queue->Offer(block);
  }
}

void Broadcast::Close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  for (const auto& queue : Queues()) {
    queue->Close();
  }
}

std::size_t Broadcast::subscribers() const {
  const std::lock_guard lock(mutex_);
  return queues_.size();
}

// A copy: a notification may subscribe and unsubscribe.
std::vector<std::shared_ptr<Broadcast::Queue>> Broadcast::Queues() const {
  const std::lock_guard lock(mutex_);
  return queues_;
}

void Broadcast::Remove(const Queue* queue) {
  const std::lock_guard lock(mutex_);
  std::erase_if(queues_, [queue](const auto& candidate) { return candidate.get() == queue; });
}

Subscription::Subscription(Broadcast& broadcast, std::shared_ptr<Broadcast::Queue> queue)
    : broadcast_(broadcast), queue_(std::move(queue)) {}

Subscription::~Subscription() {
  broadcast_.Remove(queue_.get());
  queue_->Detach();
}

std::optional<Delivery> Subscription::Take() { return queue_->Take(); }

bool Subscription::ended() const { return queue_->ended(); }

}  // namespace mwidth::record
