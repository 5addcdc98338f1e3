// The server's clock, for a client that has its own.
#pragma once

#include <chrono>

namespace mwidth::client {

/// What to add to a time of std::chrono::steady_clock since its epoch to have the axis's, and how far off
/// that may be. Clocks drift apart, by some 50 us a second at worst: ask anew every minute or so.
struct ClockOffset {
  std::chrono::nanoseconds offset{0};
  std::chrono::nanoseconds error{0};
};

}  // namespace mwidth::client
