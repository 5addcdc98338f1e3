// The counter in an encoder: a few bits that wrap around.
#pragma once

#include <cstdint>

namespace mwidth::render {

/// Makes one continuous count of a counter that wraps. Each new value is taken for the one nearest to the
/// last count among all that look the same in `bits` bits, which is right as long as the counter moved by
/// less than half its range since. The first value is read as a signed number. One thread; all Rt.
class Counter {
 public:
  /// `bits`: width of the counter, 1 to 64; at 64 nothing wraps.
  explicit Counter(int bits) noexcept : unused_bits_(64 - bits) {}

  int64_t Follow(int64_t raw) noexcept {
    count_ =
        static_cast<int64_t>(static_cast<uint64_t>(count_) + static_cast<uint64_t>(Difference(raw, count_)));
    return count_;
  }

 private:
  /// a - b modulo 2^bits, as a signed number: the bits above the counter's are shifted out, and the sign in.
  int64_t Difference(int64_t a, int64_t b) const noexcept {
    const uint64_t difference = static_cast<uint64_t>(a) - static_cast<uint64_t>(b);
    return static_cast<int64_t>(difference << unused_bits_) >> unused_bits_;
  }

  int unused_bits_;
  int64_t count_ = 0;
};

}  // namespace mwidth::render
