// One value that crosses between two threads: the newest wins, nobody waits.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <type_traits>

namespace mwidth::exchange {

/// Triple buffer for one writer and one reader thread: the writer owns one slot, the reader owns another, the
/// third is handed over by one atomic exchange. Lock-free, wait-free, no allocation, no pointer inside: it
/// may lie in memory shared between processes.
template <typename T>
class Mailbox {  // NOLINT(clang-analyzer-optin.performance.Padding): a cache line for each side is the point
  static_assert(std::is_trivially_copyable_v<T>, "what crosses is plain memory");
  static_assert(std::atomic<uint32_t>::is_always_lock_free);

 public:
  /// Makes `value` the newest. Writer only. Rt.
  void Post(const T& value) noexcept {
    slots_[writing_] = value;
    writing_ = handover_.exchange(writing_ | kFresh, std::memory_order_acq_rel) & kIndex;
  }

  /// Copies the newest value to `value` if one came since the last call; else leaves `value` alone and
  /// returns false. Reader only. Rt.
  bool Take(T& value) noexcept {
    if ((handover_.load(std::memory_order_relaxed) & kFresh) == 0) {
      return false;
    }
    reading_ = handover_.exchange(reading_, std::memory_order_acq_rel) & kIndex;
    value = slots_[reading_];
    return true;
  }

  /// The value last taken, or T{} before the first: what a reader that is made anew inherits. Reader only.
  /// Rt.
  const T& Held() const noexcept { return slots_[reading_]; }

 private:
  static constexpr uint32_t kIndex = 3;
  static constexpr uint32_t kFresh = 4;
  static constexpr std::size_t kCacheLine = 64;

  std::array<T, 3> slots_{};
  alignas(kCacheLine) std::atomic<uint32_t> handover_{1};
  alignas(kCacheLine) uint32_t writing_ = 0;
  alignas(kCacheLine) uint32_t reading_ = 2;
};

}  // namespace mwidth::exchange
