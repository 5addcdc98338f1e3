#include "server/exchange/ring.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <thread>

namespace mwidth::exchange {
namespace {

struct Numbered {
  uint64_t number = 0;
  uint64_t complement = 0;
};

TEST(RingTest, GivesValuesInTheOrderTheyCame) {
  Ring<int, 4> ring;
  int value = 0;
  EXPECT_FALSE(ring.Pop(value));
  for (int round = 0; round < 10; ++round) {
    for (int i = 0; i < 3; ++i) {
      ASSERT_TRUE(ring.Push(3 * round + i));
    }
    for (int i = 0; i < 3; ++i) {
      ASSERT_TRUE(ring.Pop(value));
      ASSERT_EQ(value, 3 * round + i);
    }
    ASSERT_FALSE(ring.Pop(value));
  }
  EXPECT_EQ(ring.dropped(), 0);
}

TEST(RingTest, DropsTheNewestWhenFullAndCountsIt) {
  Ring<int, 4> ring;
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(ring.Push(i));
  }
  EXPECT_FALSE(ring.Push(4));
  EXPECT_FALSE(ring.Push(5));
  EXPECT_EQ(ring.dropped(), 2);
  int value = -1;
  EXPECT_TRUE(ring.Pop(value));
  EXPECT_EQ(value, 0);
  EXPECT_TRUE(ring.Push(6));
  for (const int expected : {1, 2, 3, 6}) {
    EXPECT_TRUE(ring.Pop(value));
    EXPECT_EQ(value, expected);
  }
  EXPECT_FALSE(ring.Pop(value));
}

TEST(RingTest, KeepsOrderAndCountsEveryDropUnderTwoThreads) {
  constexpr uint64_t kPushes = 300'000;
  Ring<Numbered, 64> ring;
  std::atomic<bool> done{false};
  uint64_t refused = 0;
  std::thread writer([&] {
    for (uint64_t i = 1; i <= kPushes; ++i) {
      refused += ring.Push({.number = i, .complement = ~i}) ? 0 : 1;
    }
    done.store(true, std::memory_order_release);
  });
  uint64_t received = 0;
  uint64_t last = 0;
  uint64_t torn = 0;
  uint64_t out_of_order = 0;
  for (bool ended = false; !ended;) {
    ended =
        done.load(std::memory_order_acquire);  // Read first: what was pushed before it is still to be popped.
    Numbered value;
    while (ring.Pop(value)) {
      ++received;
      torn += value.complement != ~value.number ? 1 : 0;
      out_of_order += value.number <= last ? 1 : 0;
      last = value.number;
    }
  }
  writer.join();
  EXPECT_EQ(torn, 0);
  EXPECT_EQ(out_of_order, 0);
  EXPECT_EQ(ring.dropped(), refused);
  EXPECT_EQ(received + ring.dropped(), kPushes);
}

}  // namespace
}  // namespace mwidth::exchange
