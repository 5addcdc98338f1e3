// When the records of a session that is played back are due.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <thread>

#include <grpcpp/server_context.h>

namespace mwidth::rpc {

/// Waits for the time of each record, `speed` times as fast as it was; 0: never.
class Pace {
 public:
  Pace(grpc::ServerContext& context, double speed) : context_(context), speed_(speed) {}

  /// False when the client has gone.
  bool Await(int64_t monotonic_ns) {
    if (speed_ > 0) {
      if (!first_ns_) {
        first_ns_ = monotonic_ns;
      }
      const auto offset_ns = static_cast<int64_t>(static_cast<double>(monotonic_ns - *first_ns_) / speed_);
      const auto due = start_ + std::chrono::nanoseconds(offset_ns);
      for (auto now = Now(); now < due && !context_.IsCancelled(); now = Now()) {
        std::this_thread::sleep_for(std::min<std::chrono::nanoseconds>(due - now, kStep));
      }
    }
    return !context_.IsCancelled();
  }

 private:
  // How soon a reader that went away is noticed.
  static constexpr std::chrono::milliseconds kStep{50};

  static std::chrono::steady_clock::time_point Now() { return std::chrono::steady_clock::now(); }

  grpc::ServerContext& context_;
  const double speed_;
  const std::chrono::steady_clock::time_point start_ = Now();
  std::optional<int64_t> first_ns_;
};

}  // namespace mwidth::rpc
