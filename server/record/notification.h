// A call-back that its receiver can take back at any time, from anywhere.
#pragma once

#include <functional>
#include <mutex>
#include <utility>

namespace mwidth::record {

/// Shared by the one who notifies and the one who is notified, so that it outlives a notification in which
/// the latter is destroyed. Any thread.
class Notification {
 public:
  /// `notify` returns soon and does not throw.
  explicit Notification(std::function<void()> notify) : notify_(std::move(notify)) {}

  void Notify() {
    const std::lock_guard running(mutex_);
    if (!detached_) {
      notify_();
    }
  }

  /// From here on nothing is called: a call that runs on another thread is waited for, one that this comes
  /// from is the last. Hold no lock that `notify` takes.
  void Detach() {
    const std::lock_guard running(mutex_);
    detached_ = true;
  }

 private:
  const std::function<void()> notify_;
  // Held while a call runs: Detach waits for it. Recursive, because a call may detach itself.
  std::recursive_mutex mutex_;
  bool detached_ = false;
};

}  // namespace mwidth::record
