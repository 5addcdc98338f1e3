#include "server/record/broadcast.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <latch>
#include <memory>
#include <optional>
#include <random>
#include <semaphore>
#include <thread>
#include <vector>

#include "tests/server/record/samples.h"

namespace mwidth::record {
namespace {

void Ignore() {}

/// What one subscriber saw, and whether its account of it adds up.
struct Account {
  uint64_t received = 0;
  uint64_t dropped = 0;
  bool consistent = true;
  std::optional<uint64_t> next_tick;

  void TakeAll(Subscription& subscription) {
    while (const std::optional<Delivery> delivery = subscription.Take()) {
      const uint64_t first = delivery->block->front().tick;
      // Before its first block a subscriber has lost nothing.
      consistent = consistent && first == next_tick.value_or(first) + delivery->dropped_before;
      received += delivery->block->size();
      dropped += delivery->dropped_before;
      next_tick = delivery->block->back().tick + 1;
    }
  }
};

TEST(BroadcastTest, SharesEveryBlockInOrderWithEverySubscriber) {
  Broadcast broadcast;
  const auto first = broadcast.Subscribe(Ignore);
  const auto second = broadcast.Subscribe(Ignore);
  const std::vector blocks = {BlockOf(0, 5), BlockOf(5, 3), BlockOf(8, 1)};
  for (const auto& block : blocks) {
    broadcast.Consume(block);
  }
  for (const auto& subscription : {first.get(), second.get()}) {
    for (const auto& block : blocks) {
      const std::optional<Delivery> delivery = subscription->Take();
      ASSERT_TRUE(delivery);
      EXPECT_EQ(delivery->block, block);
      EXPECT_EQ(delivery->dropped_before, 0);
    }
    EXPECT_FALSE(subscription->Take());
  }
}

TEST(BroadcastTest, DeliversWhatComesAfterTheSubscription) {
  Broadcast broadcast;
  broadcast.Consume(BlockOf(0, 5));
  const auto subscription = broadcast.Subscribe(Ignore);
  EXPECT_FALSE(subscription->Take());
  broadcast.Consume(BlockOf(5, 5));
  EXPECT_EQ(subscription->Take()->block->front().tick, 5);
}

TEST(BroadcastTest, NotifiesOncePerQueuedBlockAndNotForADroppedOne) {
  Broadcast broadcast({.max_queued_samples = 10});
  int notifications = 0;
  const auto subscription = broadcast.Subscribe([&] { ++notifications; });
  broadcast.Consume(BlockOf(0, 5));
  broadcast.Consume(BlockOf(5, 5));
  EXPECT_EQ(notifications, 2);
  broadcast.Consume(BlockOf(10, 5));
  EXPECT_EQ(notifications, 2);
}

TEST(BroadcastTest, DropsTheNewestForASlowSubscriberAloneAndTellsItWithTheNextBlock) {
  Broadcast broadcast({.max_queued_samples = 10});
  const auto slow = broadcast.Subscribe(Ignore);
  const auto fast = broadcast.Subscribe(Ignore);
  Account of_fast;
  for (uint64_t tick = 0; tick < 40; tick += 4) {
    broadcast.Consume(BlockOf(tick, 4));
    of_fast.TakeAll(*fast);
  }
  EXPECT_EQ(of_fast.received, 40);
  EXPECT_EQ(of_fast.dropped, 0);
  // Two blocks of four fit into ten samples; the eight that followed did not.
  EXPECT_EQ(slow->Take()->block->front().tick, 0);
  EXPECT_EQ(slow->Take()->block->front().tick, 4);
  EXPECT_FALSE(slow->Take());
  broadcast.Consume(BlockOf(40, 4));
  broadcast.Consume(BlockOf(44, 4));
  const std::optional<Delivery> resumed = slow->Take();
  EXPECT_EQ(resumed->block->front().tick, 40);
  EXPECT_EQ(resumed->dropped_before, 32);
  EXPECT_EQ(slow->Take()->dropped_before, 0);
}

TEST(BroadcastTest, AnEmptyQueueTakesABlockLargerThanItsLimit) {
  Broadcast broadcast({.max_queued_samples = 10});
  const auto subscription = broadcast.Subscribe(Ignore);
  broadcast.Consume(BlockOf(0, 500));
  broadcast.Consume(BlockOf(500, 1));
  EXPECT_EQ(subscription->Take()->block->size(), 500);
  EXPECT_FALSE(subscription->Take());
  broadcast.Consume(BlockOf(501, 1));
  EXPECT_EQ(subscription->Take()->dropped_before, 1);
}

TEST(BroadcastTest, RefusesSubscribersBeyondTheLimitUntilOneLeaves) {
  Broadcast broadcast({.max_subscribers = 2});
  auto first = broadcast.Subscribe(Ignore);
  const auto second = broadcast.Subscribe(Ignore);
  EXPECT_EQ(broadcast.Subscribe(Ignore), nullptr);
  EXPECT_EQ(broadcast.subscribers(), 2);
  first.reset();
  EXPECT_NE(broadcast.Subscribe(Ignore), nullptr);
}

TEST(BroadcastTest, EndsSubscriptionsOnceEverythingIsTaken) {
  Broadcast broadcast;
  int notifications = 0;
  const auto subscription = broadcast.Subscribe([&] { ++notifications; });
  broadcast.Consume(BlockOf(0, 5));
  broadcast.Close();
  EXPECT_EQ(notifications, 2);
  EXPECT_FALSE(subscription->ended());
  EXPECT_TRUE(subscription->Take());
  EXPECT_TRUE(subscription->ended());
  EXPECT_TRUE(broadcast.Subscribe(Ignore)->ended());
}

TEST(BroadcastTest, ANotificationMayEndItsOwnSubscription) {
  Broadcast broadcast;
  int notifications = 0;
  std::unique_ptr<Subscription> subscription;
  subscription = broadcast.Subscribe([&] {
    ++notifications;
    subscription.reset();
  });
  broadcast.Consume(BlockOf(0, 1));
  broadcast.Consume(BlockOf(1, 1));
  EXPECT_EQ(notifications, 1);
  EXPECT_EQ(broadcast.subscribers(), 0);
}

TEST(BroadcastTest, ANotificationMayEndAnotherSubscriptionAndBeginOne) {
  Broadcast broadcast;
  int notifications_of_other = 0;
  std::unique_ptr<Subscription> other;
  std::unique_ptr<Subscription> late;
  const auto subscription = broadcast.Subscribe([&] {
    other.reset();
    if (late == nullptr) {
      late = broadcast.Subscribe(Ignore);
    }
  });
  other = broadcast.Subscribe([&] { ++notifications_of_other; });
  broadcast.Consume(BlockOf(0, 1));
  EXPECT_EQ(notifications_of_other, 0);
  EXPECT_FALSE(late->Take());
  broadcast.Consume(BlockOf(1, 1));
  EXPECT_EQ(late->Take()->block->front().tick, 1);
}

TEST(BroadcastTest, EndingASubscriptionWaitsForItsRunningNotification) {
  Broadcast broadcast;
  std::latch notified(1);
  std::latch ending(1);
  std::atomic<bool> ended = false;
  bool ended_during_notification = true;
  auto subscription = broadcast.Subscribe([&] {
    notified.count_down();
    ending.wait();
    std::this_thread::yield();  // so that an end that does not wait would get its chance
    ended_during_notification = ended;
  });
  std::thread consumer([&] { broadcast.Consume(BlockOf(0, 1)); });
  notified.wait();
  ending.count_down();
  subscription.reset();
  ended = true;
  consumer.join();
  EXPECT_FALSE(ended_during_notification);
}

TEST(BroadcastTest, AccountsForEverySampleWhileSubscribersComeAndGo) {
  constexpr int kThreads = 4;
  constexpr int kVisits = 20;
  Broadcast broadcast({.max_subscribers = kThreads, .max_queued_samples = 20});
  std::atomic<int> visitors = kThreads;
  std::vector<std::thread> threads;
  threads.reserve(kThreads);
  for (int seed = 0; seed < kThreads; ++seed) {
    threads.emplace_back([&, seed] {
      std::mt19937 random(static_cast<std::mt19937::result_type>(seed));
      for (int visit = 0; visit < kVisits; ++visit) {
        std::counting_semaphore notified(0);
        const auto subscription = broadcast.Subscribe([&] { notified.release(); });
        ASSERT_NE(subscription, nullptr);
        Account account;
        const auto wanted = random() % 100;
        while (account.received < wanted) {
          notified.acquire();
          account.TakeAll(*subscription);
        }
        EXPECT_TRUE(account.consistent);
      }
      --visitors;
    });
  }
  uint64_t tick = 0;
  while (visitors > 0) {
    broadcast.Consume(BlockOf(tick, 7));
    tick += 7;
    std::this_thread::yield();
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_EQ(broadcast.subscribers(), 0);
}

}  // namespace
}  // namespace mwidth::record
