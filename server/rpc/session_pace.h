// When the samples of a session that is played back are due.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <thread>

#include <grpcpp/server_context.h>

namespace mwidth::rpc {

/// Samples come `speed` times as fast as they did; 0: at once. What stands between them comes with those
/// behind it: a marker may be dated by any clock.
class Pace {
 public:
  Pace(grpc::ServerContext& context, double speed) : context_(context), speed_(speed) {}

  /// Waits for the time of a sample. False when the client has gone.
  bool Await(int64_t monotonic_ns) {
    if (speed_ > 0) {
      first_ns_ = first_ns_.value_or(monotonic_ns);
      // Unsigned, because a file may say any two times.
      const auto since_ns =
          static_cast<double>(static_cast<uint64_t>(monotonic_ns) - static_cast<uint64_t>(*first_ns_));
      const std::chrono::duration<double> due(std::min(since_ns / speed_ / kNsPerS, kLongestS));
      while (std::chrono::steady_clock::now() - start_ < due && !context_.IsCancelled()) {
        std::this_thread::sleep_for(std::min<std::chrono::duration<double>>(
            due - (std::chrono::steady_clock::now() - start_), kStep));
      }
    }
    return !context_.IsCancelled();
  }

 private:
  static constexpr double kNsPerS = 1e9;
  static constexpr double kLongestS = 1e9;
  // How soon a reader that went away is noticed.
  static constexpr std::chrono::milliseconds kStep{50};

  grpc::ServerContext& context_;
  const double speed_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::optional<int64_t> first_ns_;
};

}  // namespace mwidth::rpc
