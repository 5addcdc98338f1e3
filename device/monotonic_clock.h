// The time that links and drives are held to.
#pragma once

#include <cstdint>
#include <ctime>

namespace mwidth::device {

/// Nanoseconds of CLOCK_MONOTONIC. Rt.
inline int64_t NowNs() noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * 1'000'000'000L + now.tv_nsec;
}

/// NowNs, or a test's own time. Rt.
using Now = int64_t (*)() noexcept;

}  // namespace mwidth::device
