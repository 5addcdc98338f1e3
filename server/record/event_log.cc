#include "server/record/event_log.h"

#include <algorithm>
#include <utility>

namespace mwidth::record {

void EventLog::SetSink(std::function<void(const Event&)> sink) {
  const std::lock_guard publishing(publishing_);
  sink_ = std::move(sink);
}

void EventLog::Publish(EventKind kind, std::string message, Metadata metadata, std::optional<uint64_t> tick) {
  {
    const std::lock_guard publishing(publishing_);
    Event event{.number = newest() + 1,
                .kind = kind,
                .tick = tick.value_or(newest_tick_.load(std::memory_order_relaxed)),
                .monotonic_ns = clock_.NowNs(),
                .message = std::move(message),
                .metadata = std::move(metadata)};
    if (sink_) {
      sink_(event);
    }
    const std::lock_guard lock(mutex_);
    ++newest_;
    remembered_.push_back(std::move(event));
    if (remembered_.size() > kRemembered) {
      remembered_.pop_front();
    }
  }
  for (const auto& listener : Listeners()) {
    listener->Notify();
  }
}

uint64_t EventLog::newest() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

std::unique_ptr<EventSubscription> EventLog::Subscribe(uint64_t after, std::size_t max_subscribers,
                                                       std::function<void()> notify) {
  auto notification = std::make_shared<Notification>(std::move(notify));
  const std::lock_guard lock(mutex_);
  if (listeners_.size() >= max_subscribers) {
    return nullptr;
  }
  listeners_.push_back(notification);
  // A number of another life of the server says nothing about this one.
  return std::unique_ptr<EventSubscription>(
      new EventSubscription(*this, std::move(notification), std::min(after, newest_)));
}

void EventLog::Close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  for (const auto& listener : Listeners()) {
    listener->Notify();
  }
}

// A copy: a notification may subscribe and unsubscribe.
std::vector<std::shared_ptr<Notification>> EventLog::Listeners() const {
  const std::lock_guard lock(mutex_);
  return listeners_;
}

EventSubscription::EventSubscription(EventLog& log, std::shared_ptr<Notification> notification,
                                     uint64_t after)
    : log_(log), notification_(std::move(notification)), taken_(after) {}

EventSubscription::~EventSubscription() {
  {
    const std::lock_guard lock(log_.mutex_);
    std::erase(log_.listeners_, notification_);
  }
  notification_->Detach();
}

std::optional<EventSubscription::Delivery> EventSubscription::Take() {
  const std::lock_guard lock(log_.mutex_);
  if (taken_ == log_.newest_) {
    return std::nullopt;
  }
  const uint64_t oldest = log_.remembered_.front().number;
  const uint64_t next = std::max(taken_ + 1, oldest);
  const uint64_t lost = next - taken_ - 1;
  taken_ = next;
  return Delivery{.event = log_.remembered_[next - oldest], .lost_before = lost};
}

bool EventSubscription::ended() const {
  const std::lock_guard lock(log_.mutex_);
  return log_.closed_ && taken_ == log_.newest_;
}

}  // namespace mwidth::record
