#include "device/reconnection.h"

#include <chrono>
#include <stdexcept>
#include <utility>

namespace mwidth::device {

Reconnection::Reconnection(std::function<void()> connect)
    : connect_(std::move(connect)), thread_([this](const std::stop_token& stop) { Run(stop); }) {}

void Reconnection::Stop() {
  if (thread_.joinable()) {
    thread_.request_stop();
    thread_.join();
  }
}

void Reconnection::Run(const std::stop_token& stop) {
  constexpr std::chrono::milliseconds kPause{100};
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    ending_.wait_for(lock, stop, kPause, [] { return false; });
    if (stop.stop_requested() || HasLink()) {
      continue;
    }
    try {
      connect_();
      lost_.store(false, std::memory_order_release);
    } catch (const std::runtime_error&) {  // NOLINT(bugprone-empty-catch): the loop tells of the silence; try
                                           // again
    }
  }
}

}  // namespace mwidth::device
