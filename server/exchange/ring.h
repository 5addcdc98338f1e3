// A queue of samples out of the loop: nothing is lost silently.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace mwidth::exchange {

/// Bounded queue for one writer and one reader thread. A full ring drops the new value and counts it.
/// Lock-free, wait-free, no allocation, no pointer inside.
template <typename T, std::size_t kCapacity>
class Ring {
  static_assert(std::is_trivially_copyable_v<T>, "what crosses is plain memory");
  static_assert(kCapacity > 0 && (kCapacity & (kCapacity - 1)) == 0, "capacity is a power of two");
  static_assert(std::atomic<uint64_t>::is_always_lock_free);

 public:
  /// Appends `value`, or counts it as dropped and returns false when the ring is full. Writer only. Rt.
  bool Push(const T& value) noexcept {
    const uint64_t head = head_.load(std::memory_order_relaxed);
    if (head - tail_.load(std::memory_order_acquire) == kCapacity) {
      dropped_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    slots_[head & (kCapacity - 1)] = value;
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  /// Moves the oldest value to `value`; false when the ring is empty. Reader only.
  bool Pop(T& value) noexcept {
    const uint64_t tail = tail_.load(std::memory_order_relaxed);
    if (tail == head_.load(std::memory_order_acquire)) {
      return false;
    }
    value = slots_[tail & (kCapacity - 1)];
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /// How many values were dropped since the start. Any thread.
  uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t kCacheLine = 64;

  std::array<T, kCapacity> slots_{};
  alignas(kCacheLine) std::atomic<uint64_t> head_{0};
  alignas(kCacheLine) std::atomic<uint64_t> tail_{0};
  alignas(kCacheLine) std::atomic<uint64_t> dropped_{0};
};

}  // namespace mwidth::exchange
