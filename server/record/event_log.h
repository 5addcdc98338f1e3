// The events of one axis: numbered, remembered for a while, told to whoever listens.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/exchange/clock.h"
#include "server/record/event.h"
#include "server/record/notification.h"

namespace mwidth::record {

class EventSubscription;

/// Nobody is waited for: a subscriber is a place in what is remembered, and one that falls behind that learns
/// how many events it lost. Any thread; outlives its subscriptions.
class EventLog {
 public:
  static constexpr std::size_t kRemembered = 1000;

  using Metadata = std::map<std::string, std::string>;

  /// `clock`, the axis's, outlives the log.
  explicit EventLog(const exchange::Clock& clock) : clock_(clock) {}
  EventLog(const EventLog&) = delete;
  EventLog& operator=(const EventLog&) = delete;

  /// Of every later event; called by the thread that publishes, in the order of their numbers. Publishes
  /// nothing itself.
  void SetSink(std::function<void(const Event&)> sink);

  /// At the clock's present time, and at `tick` or else the newest one noted.
  void Publish(EventKind kind, std::string message, Metadata metadata = {},
               std::optional<uint64_t> tick = std::nullopt);

  /// The newest tick that is known of.
  void NoteTick(uint64_t tick) { newest_tick_.store(tick, std::memory_order_relaxed); }

  /// The number of the newest event; 0 where there is none.
  uint64_t newest() const;

  /// To the events behind number `after`. `notify` is called after an event was published, and after Close;
  /// see Notification. It can run before Subscribe returns. nullptr where there are `max_subscribers`
  /// already.
  std::unique_ptr<EventSubscription> Subscribe(uint64_t after, std::size_t max_subscribers,
                                               std::function<void()> notify);

  /// Ends every subscription, once what is remembered is taken.
  void Close();

 private:
  friend class EventSubscription;

  std::vector<std::shared_ptr<Notification>> Listeners() const;

  const exchange::Clock& clock_;
  std::atomic<uint64_t> newest_tick_{0};
  // Keeps the sink's events in order; taken before mutex_.
  std::mutex publishing_;
  std::function<void(const Event&)> sink_;
  mutable std::mutex mutex_;
  // Without gaps in their numbers.
  std::deque<Event> remembered_;
  uint64_t newest_ = 0;
  bool closed_ = false;
  std::vector<std::shared_ptr<Notification>> listeners_;
};

/// One reader's place.
class EventSubscription {
 public:
  struct Delivery {
    Event event;
    /// Events before this one that were forgotten before they were taken.
    uint64_t lost_before = 0;
  };

  EventSubscription(const EventSubscription&) = delete;
  EventSubscription& operator=(const EventSubscription&) = delete;
  /// Unsubscribes; see Notification::Detach.
  ~EventSubscription();

  /// The oldest event not taken yet, if any. One thread at a time.
  std::optional<Delivery> Take();
  /// True when the log is closed and everything is taken. One thread at a time.
  bool ended() const;

 private:
  friend class EventLog;
  EventSubscription(EventLog& log, std::shared_ptr<Notification> notification, uint64_t after);

  EventLog& log_;
  const std::shared_ptr<Notification> notification_;
  uint64_t taken_;
};

}  // namespace mwidth::record
