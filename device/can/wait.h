// Waiting for bytes until a time, and not a time-out longer.
#pragma once

#include <poll.h>

#include <algorithm>
#include <cstdint>
#include <ctime>

#include "device/monotonic_clock.h"

namespace mwidth::device::can {

/// False when nothing can be read from `file` by `deadline_ns`. ppoll, because poll counts milliseconds. Rt.
inline bool WaitToRead(int file, int64_t deadline_ns) noexcept {
  constexpr int64_t kSecond = 1'000'000'000;
  const int64_t left_ns = std::max<int64_t>(deadline_ns - NowNs(), 0);
  const timespec left{.tv_sec = left_ns / kSecond, .tv_nsec = left_ns % kSecond};
  pollfd wanted{.fd = file, .events = POLLIN, .revents = 0};
  return ppoll(&wanted, 1, &left, nullptr) > 0;
}

}  // namespace mwidth::device::can
