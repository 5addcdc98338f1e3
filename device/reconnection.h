// Makes the link of a drive anew while the loop goes on.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>

namespace mwidth::device {

/// Says whose the link is: the loop's thread has it until it loses it; then a thread of this class has it,
/// until it is connected again. To be the last member of a drive.
class Reconnection {
 public:
  /// `connect` connects and takes the force away; it throws std::runtime_error where it cannot, and is tried
  /// again. Only called while the link is lost, on the thread of this class.
  explicit Reconnection(std::function<void()> connect);
  Reconnection(const Reconnection&) = delete;
  Reconnection& operator=(const Reconnection&) = delete;
  ~Reconnection() { Stop(); }

  /// The loop's thread may use the link. Rt.
  bool HasLink() const noexcept { return !lost_.load(std::memory_order_acquire); }
  /// Hands the link over: the loop's thread leaves it alone from here on. Rt.
  void Lose() noexcept { lost_.store(true, std::memory_order_release); }
  /// Ends the thread, behind an attempt that is under way. Does no harm twice.
  void Stop();

 private:
  void Run(const std::stop_token& stop);

  const std::function<void()> connect_;
  std::atomic<bool> lost_{false};
  std::mutex mutex_;
  std::condition_variable_any ending_;
  std::jthread thread_;
};

}  // namespace mwidth::device
