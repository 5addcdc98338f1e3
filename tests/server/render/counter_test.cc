#include "server/render/counter.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>

namespace mwidth::render {
namespace {

// What a counter of `bits` shows of `count`, as an unsigned or a signed number.
int64_t Shown(int64_t count, int bits, bool as_signed) {
  const uint64_t mask = bits == 64 ? UINT64_MAX : (uint64_t{1} << bits) - 1;
  const uint64_t shown = static_cast<uint64_t>(count) & mask;
  const bool negative = as_signed && ((shown >> (bits - 1)) & 1) != 0;
  return static_cast<int64_t>(negative ? shown | ~mask : shown);
}

TEST(CounterTest, IsContinuousWhereTheCounterWraps) {
  std::mt19937_64 random(1);
  for (const int bits : {8, 16, 24, 32, 48, 63, 64}) {
    for (const bool as_signed : {false, true}) {
      Counter counter(bits);
      int64_t count = 0;
      // Steps up to just below half the range, so that it wraps all the time.
      const int64_t half =
          bits == 64 ? INT64_MAX / 1000 : (int64_t{1} << (bits - 1)) / (bits > 48 ? 1000 : 1);
      std::uniform_int_distribution<int64_t> step(-half + 1, half - 1);
      for (int i = 0; i < 500; ++i) {
        ASSERT_EQ(counter.Follow(Shown(count, bits, as_signed)), count) << bits << " bits, step " << i;
        count += step(random);
      }
    }
  }
}

TEST(CounterTest, CountsOnOverManyTurnsOfASixteenBitCounter) {
  Counter counter(16);
  int64_t count = -5;
  for (; count < 10'000'000; count += 32'767) {
    ASSERT_EQ(counter.Follow(count & 0xFFFF), count);
  }
  for (; count > -10'000'000; count -= 32'767) {
    ASSERT_EQ(counter.Follow(count & 0xFFFF), count);
  }
}

TEST(CounterTest, ReadsTheFirstValueAsASignedNumber) {
  EXPECT_EQ(Counter(16).Follow(0xFFFF), -1);
  EXPECT_EQ(Counter(16).Follow(0x7FFF), 0x7FFF);
  EXPECT_EQ(Counter(32).Follow(0x80000000), INT32_MIN);
  EXPECT_EQ(Counter(64).Follow(INT64_MIN), INT64_MIN);
}

TEST(CounterTest, KeepsTheCountsOfACounterThatDoesNotWrap) {
  Counter counter(64);
  for (const int64_t count : {INT64_MAX, INT64_MIN, int64_t{0}, int64_t{-1}, INT64_MAX}) {
    EXPECT_EQ(counter.Follow(count), count);
  }
}

}  // namespace
}  // namespace mwidth::render
