#include "server/record/event_log.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "tests/server/gate/fake_loop.h"

namespace mwidth::record {
namespace {

class EventLogTest : public testing::Test {
 protected:
  void Publish(int count) {
    for (int i = 0; i < count; ++i) {
      log_.Publish(EventKind::kStateChanged, "IDLE to READY");
    }
  }

  gate::FakeClock clock_;
  EventLog log_{clock_};
};

TEST_F(EventLogTest, NumbersEventsAndDatesThemByTheAxissClock) {
  clock_.AdvanceS(2);
  log_.NoteTick(41);
  log_.Publish(EventKind::kMassSet, "first", {{"mass", "1"}});
  log_.Publish(EventKind::kMassRefused, "second", {}, 77);
  const auto subscription = log_.Subscribe(0, 1, [] {});
  const Event first = subscription->Take()->event;
  EXPECT_EQ(first, (Event{.number = 1,
                          .kind = EventKind::kMassSet,
                          .tick = 41,
                          .monotonic_ns = clock_.NowNs(),
                          .message = "first",
                          .metadata = {{"mass", "1"}}}));
  const Event second = subscription->Take()->event;
  EXPECT_EQ(second.number, 2);
  EXPECT_EQ(second.tick, 77);
  EXPECT_FALSE(subscription->Take());
}

TEST_F(EventLogTest, BeginsBehindTheNumberThatIsNamed) {
  Publish(3);
  const auto subscription = log_.Subscribe(2, 1, [] {});
  EXPECT_EQ(subscription->Take()->event.number, 3);
}

TEST_F(EventLogTest, TakesANumberOfAnotherLifeForTheNewest) {
  Publish(3);
  const auto subscription = log_.Subscribe(1'000'000, 1, [] {});
  EXPECT_FALSE(subscription->Take());
  Publish(1);
  EXPECT_EQ(subscription->Take()->event.number, 4);
}

TEST_F(EventLogTest, TellsALateReaderHowManyEventsAreForgotten) {
  const auto subscription = log_.Subscribe(0, 1, [] {});
  Publish(static_cast<int>(EventLog::kRemembered) + 5);
  const auto delivery = subscription->Take();
  EXPECT_EQ(delivery->lost_before, 5);
  EXPECT_EQ(delivery->event.number, 6);
  EXPECT_EQ(subscription->Take()->lost_before, 0);
}

TEST_F(EventLogTest, NotifiesUntilTheSubscriptionIsGone) {
  int notified = 0;
  auto subscription = log_.Subscribe(0, 1, [&notified] { ++notified; });
  Publish(2);
  EXPECT_EQ(notified, 2);
  subscription.reset();
  Publish(1);
  EXPECT_EQ(notified, 2);
}

TEST_F(EventLogTest, HasRoomForSoManySubscribers) {
  const auto first = log_.Subscribe(0, 1, [] {});
  EXPECT_EQ(log_.Subscribe(0, 1, [] {}), nullptr);
}

TEST_F(EventLogTest, EndsWhenItIsClosedAndEverythingTaken) {
  int notified = 0;
  const auto subscription = log_.Subscribe(0, 1, [&notified] { ++notified; });
  Publish(1);
  log_.Close();
  EXPECT_EQ(notified, 2);
  EXPECT_FALSE(subscription->ended());
  subscription->Take();
  EXPECT_TRUE(subscription->ended());
}

TEST_F(EventLogTest, GivesTheSinkEveryEventInOrderWhoeverPublishes) {
  std::vector<uint64_t> numbers;
  log_.SetSink([&numbers](const Event& event) { numbers.push_back(event.number); });
  constexpr int kEach = 500;
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 4; ++i) {
      threads.emplace_back([this] { Publish(kEach); });
    }
  }
  ASSERT_EQ(numbers.size(), 4 * kEach);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    EXPECT_EQ(numbers[i], i + 1);
  }
}

TEST_F(EventLogTest, MayBeLeftFromWithinANotification) {
  std::unique_ptr<EventSubscription> subscription;
  subscription = log_.Subscribe(0, 1, [&subscription] { subscription.reset(); });
  Publish(2);
  EXPECT_EQ(subscription, nullptr);
}

}  // namespace
}  // namespace mwidth::record
