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
#include <string>
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
    for (Delivery delivery; subscription.Take(delivery);) {
      const uint64_t first = delivery.first_tick();
      // Before its first batch a subscriber has lost nothing.
      consistent = consistent && first == next_tick.value_or(first) + delivery.dropped_ticks_before;
      received += delivery.samples();
      dropped += delivery.dropped_ticks_before;
      next_tick = first + delivery.samples();
    }
  }
};

std::string TakeBytes(Subscription& subscription) {
  std::string bytes;
  for (Delivery delivery; subscription.Take(delivery);) {
    for (const auto& batch : delivery.batches) {
      bytes += batch->bytes;
    }
    bytes += ";";
  }
  return bytes;
}

TEST(BroadcastTest, EncodesABatchOnceForAllSubscribersOfOneCut) {
  int encodings = 0;
  Broadcast broadcast([&](const Batch& batch) {
    ++encodings;
    return EncodeTicks(batch);
  });
  const auto first = broadcast.Subscribe({}, 0, Ignore);
  const auto second = broadcast.Subscribe({}, 0, Ignore);
  const auto other = broadcast.Subscribe({.decimation = 2}, 0, Ignore);
  EXPECT_EQ(broadcast.groups(), 2);
  // The first batch of a stream is its own, or shared by those who begin together.
  broadcast.Consume(BlockOf(0, 4));
  encodings = 0;
  broadcast.Consume(BlockOf(4, 4));
  EXPECT_EQ(encodings, 2);
  Delivery of_first;
  Delivery of_second;
  ASSERT_TRUE(first->Take(of_first));
  ASSERT_TRUE(second->Take(of_second));
  EXPECT_EQ(of_first.batches.back(), of_second.batches.back());
  EXPECT_EQ(TakeBytes(*other), " 0 2 4 6;");
}

TEST(BroadcastTest, IsEagerAsLongAsAnybodyWantsSmallBatches) {
  Broadcast broadcast(EncodeTicks);
  EXPECT_FALSE(broadcast.eager());
  const auto patient = broadcast.Subscribe({.min_batch = 100, .max_batch = 100}, 0, Ignore);
  const auto decimated = broadcast.Subscribe({.decimation = 10, .min_batch = 10}, 0, Ignore);
  EXPECT_FALSE(broadcast.eager());
  auto eager = broadcast.Subscribe({.min_batch = 99}, 0, Ignore);
  EXPECT_TRUE(broadcast.eager());
  eager.reset();
  EXPECT_FALSE(broadcast.eager());
}

TEST(BroadcastTest, ASubscriptionBeginsWithItsFirstTickInTheMiddleOfABatch) {
  Broadcast broadcast(EncodeTicks);
  const Cut cut{.min_batch = 8, .max_batch = 8};
  const auto early = broadcast.Subscribe(cut, 0, Ignore);
  broadcast.Consume(BlockOf(0, 4));
  const auto late = broadcast.Subscribe(cut, 6, Ignore);
  const auto later = broadcast.Subscribe(cut, 9, Ignore);
  broadcast.Consume(BlockOf(4, 4));
  EXPECT_EQ(TakeBytes(*early), " 0 1 2 3 4 5 6 7;");
  EXPECT_EQ(TakeBytes(*late), " 6 7;");
  EXPECT_EQ(TakeBytes(*later), "");
  broadcast.Consume(BlockOf(8, 8));
  EXPECT_EQ(TakeBytes(*late), " 8 9 10 11 12 13 14 15;");
  EXPECT_EQ(TakeBytes(*later), " 9 10 11 12 13 14 15;");
}

TEST(BroadcastTest, NothingIsAbsentBeforeTheFirstSampleOfASubscription) {
  Broadcast broadcast(EncodeTicks);
  const auto early = broadcast.Subscribe({}, 0, Ignore);
  broadcast.Consume(BlockOf(0, 4));
  const auto late = broadcast.Subscribe({}, 0, Ignore);
  broadcast.Consume(BlockOf(10, 4));
  Delivery delivery;
  ASSERT_TRUE(late->Take(delivery));
  EXPECT_EQ(delivery.dropped_ticks_before, 0);
  ASSERT_TRUE(early->Take(delivery));
  ASSERT_TRUE(early->Take(delivery));
  EXPECT_EQ(delivery.dropped_ticks_before, 6);
}

TEST(BroadcastTest, DeliversWhatComesAfterTheSubscription) {
  Broadcast broadcast(EncodeTicks);
  broadcast.Consume(BlockOf(0, 5));
  const auto subscription = broadcast.Subscribe({}, 0, Ignore);
  broadcast.Consume(BlockOf(5, 2));
  EXPECT_EQ(TakeBytes(*subscription), " 5 6;");
}

TEST(BroadcastTest, EndsTheBatchesOfManySubscribersAtDifferentTicks) {
  Broadcast broadcast(EncodeTicks, {.max_subscribers = 4 * Broadcast::kGroupSize});
  const Cut cut{.min_batch = 16, .max_batch = 16};
  std::vector<std::unique_ptr<Subscription>> subscriptions;
  std::vector<Account> accounts(4 * Broadcast::kGroupSize);
  std::vector<std::size_t> written_at(16);
  for (std::size_t i = 0; i < accounts.size(); ++i) {
    subscriptions.push_back(broadcast.Subscribe(cut, 0, Ignore));
  }
  EXPECT_EQ(broadcast.groups(), 4);
  for (uint64_t tick = 0; tick < 64; ++tick) {
    broadcast.Consume(BlockOf(tick, 1));
    for (std::size_t i = 0; i < accounts.size(); ++i) {
      const uint64_t before = accounts[i].received;
      accounts[i].TakeAll(*subscriptions[i]);
      written_at[tick % 16] += accounts[i].received > before ? 1 : 0;
    }
  }
  // A quarter of them each time, four times each.
  EXPECT_THAT(written_at, testing::ElementsAre(0, 0, 0, 256, 0, 0, 0, 256, 0, 0, 0, 256, 0, 0, 0, 256));
  broadcast.Close();
  for (std::size_t i = 0; i < accounts.size(); ++i) {
    accounts[i].TakeAll(*subscriptions[i]);
    EXPECT_EQ(accounts[i].received, 64);
    EXPECT_EQ(accounts[i].dropped, 0);
  }
  subscriptions.clear();
  EXPECT_EQ(broadcast.groups(), 0);
}

TEST(BroadcastTest, NotifiesOncePerBlockThatHasBatches) {
  Broadcast broadcast(EncodeTicks, {.max_queued_samples = 100});
  int notifications = 0;
  const auto subscription =
      broadcast.Subscribe({.decimation = 10, .max_batch = 1}, 0, [&] { ++notifications; });
  broadcast.Consume(BlockOf(1, 9));
  EXPECT_EQ(notifications, 0);
  broadcast.Consume(BlockOf(10, 30));
  EXPECT_EQ(notifications, 1);
}

TEST(BroadcastTest, DropsTheNewestForASlowSubscriberAloneAndTellsItWithTheNextBatch) {
  Broadcast broadcast(EncodeTicks, {.max_queued_samples = 10});
  const auto slow = broadcast.Subscribe({}, 0, Ignore);
  const auto fast = broadcast.Subscribe({}, 0, Ignore);
  Account of_fast;
  for (uint64_t tick = 0; tick < 40; tick += 4) {
    broadcast.Consume(BlockOf(tick, 4));
    of_fast.TakeAll(*fast);
  }
  EXPECT_EQ(of_fast.received, 40);
  EXPECT_EQ(of_fast.dropped, 0);
  // Two batches of four fit into ten samples, and make one; the eight that followed did not.
  EXPECT_EQ(TakeBytes(*slow), " 0 1 2 3 4 5 6 7;");
  broadcast.Consume(BlockOf(40, 4));
  broadcast.Consume(BlockOf(44, 4));
  Delivery resumed;
  ASSERT_TRUE(slow->Take(resumed));
  EXPECT_EQ(resumed.first_tick(), 40);
  EXPECT_EQ(resumed.dropped_ticks_before, 32);
  EXPECT_FALSE(resumed.as_encoded());
  EXPECT_EQ(resumed.samples(), 8);
}

TEST(BroadcastTest, RefusesSubscribersBeyondTheLimitUntilOneLeaves) {
  Broadcast broadcast(EncodeTicks, {.max_subscribers = 2});
  auto first = broadcast.Subscribe({}, 0, Ignore);
  const auto second = broadcast.Subscribe({}, 0, Ignore);
  EXPECT_EQ(broadcast.Subscribe({}, 0, Ignore), nullptr);
  EXPECT_EQ(broadcast.subscribers(), 2);
  first.reset();
  EXPECT_NE(broadcast.Subscribe({}, 0, Ignore), nullptr);
}

TEST(BroadcastTest, EndsSubscriptionsOnceEverythingIsTaken) {
  Broadcast broadcast(EncodeTicks);
  int notifications = 0;
  const auto subscription = broadcast.Subscribe({}, 0, [&] { ++notifications; });
  broadcast.Consume(BlockOf(0, 5));
  broadcast.Close();
  EXPECT_EQ(notifications, 2);
  EXPECT_FALSE(subscription->ended());
  Delivery delivery;
  EXPECT_TRUE(subscription->Take(delivery));
  EXPECT_TRUE(subscription->ended());
  EXPECT_TRUE(broadcast.Subscribe({}, 0, Ignore)->ended());
}

TEST(BroadcastTest, ANotificationMayEndItsOwnSubscription) {
  Broadcast broadcast(EncodeTicks);
  int notifications = 0;
  std::unique_ptr<Subscription> subscription;
  subscription = broadcast.Subscribe({}, 0, [&] {
    ++notifications;
    subscription.reset();
  });
  broadcast.Consume(BlockOf(0, 1));
  broadcast.Consume(BlockOf(1, 1));
  EXPECT_EQ(notifications, 1);
  EXPECT_EQ(broadcast.subscribers(), 0);
}

TEST(BroadcastTest, ANotificationMayEndAnotherSubscriptionAndBeginOne) {
  Broadcast broadcast(EncodeTicks);
  int notifications_of_other = 0;
  std::unique_ptr<Subscription> other;
  std::unique_ptr<Subscription> late;
  const auto subscription = broadcast.Subscribe({}, 0, [&] {
    other.reset();
    if (late == nullptr) {
      late = broadcast.Subscribe({}, 0, Ignore);
    }
  });
  other = broadcast.Subscribe({}, 0, [&] { ++notifications_of_other; });
  broadcast.Consume(BlockOf(0, 1));
  EXPECT_EQ(notifications_of_other, 0);
  Delivery delivery;
  EXPECT_FALSE(late->Take(delivery));
  broadcast.Consume(BlockOf(1, 1));
  ASSERT_TRUE(late->Take(delivery));
  EXPECT_EQ(delivery.first_tick(), 1);
}

TEST(BroadcastTest, EndingASubscriptionWaitsForItsRunningNotification) {
  Broadcast broadcast(EncodeTicks);
  std::latch notified(1);
  std::latch ending(1);
  std::atomic<bool> ended = false;
  bool ended_during_notification = true;
  auto subscription = broadcast.Subscribe({}, 0, [&] {
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
  Broadcast broadcast(EncodeTicks, {.max_subscribers = kThreads, .max_queued_samples = 20});
  std::atomic<int> visitors = kThreads;
  std::vector<std::thread> threads;
  threads.reserve(kThreads);
  for (int seed = 0; seed < kThreads; ++seed) {
    threads.emplace_back([&, seed] {
      std::mt19937 random(static_cast<std::mt19937::result_type>(seed));
      for (int visit = 0; visit < kVisits; ++visit) {
        std::counting_semaphore notified(0);
        const auto subscription = broadcast.Subscribe({}, 0, [&] { notified.release(); });
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
