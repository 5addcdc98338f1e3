#include "server/record/loop_events.h"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <vector>

#include "tests/server/gate/fake_loop.h"
#include "tests/server/record/samples.h"

namespace mwidth::record {
namespace {

using exchange::State;

class LoopEventsTest : public testing::Test {
 protected:
  void Consume(const SampleBlock& samples) { events_.Consume(std::make_shared<SampleBlock>(samples)); }

  static exchange::Sample At(uint64_t tick, State state, uint64_t missed = 0) {
    exchange::Sample sample = SampleAt(tick);
    sample.monotonic_ns = static_cast<int64_t>(tick) * 1'000'000;
    sample.state = state;
    sample.missed_ticks = missed;
    return sample;
  }

  std::vector<Event> Published() {
    std::vector<Event> published;
    while (auto delivery = subscription_->Take()) {
      published.push_back(delivery->event);
    }
    return published;
  }

  gate::FakeClock clock_;
  EventLog log_{clock_};
  std::unique_ptr<EventSubscription> subscription_ = log_.Subscribe(0, 1, [] {});
  LoopEvents events_{log_, [](State from, State to) {
                       return StateNote{.message = std::to_string(static_cast<int>(from)) + " to " +
                                                   std::to_string(static_cast<int>(to)),
                                        .metadata = {{"figure", "7"}}};
                     }};
};

TEST_F(LoopEventsTest, TellsAChangeOfStateAtItsTick) {
  Consume({At(1, State::kIdle), At(2, State::kIdle), At(3, State::kReady)});
  Consume({At(4, State::kFault)});
  const std::vector<Event> published = Published();
  ASSERT_EQ(published.size(), 2);
  EXPECT_EQ(published[0].kind, EventKind::kStateChanged);
  EXPECT_EQ(published[0].tick, 3);
  EXPECT_EQ(published[0].message, "0 to 1");
  EXPECT_EQ(published[1].kind, EventKind::kFault);
  EXPECT_EQ(published[1].tick, 4);
  EXPECT_EQ(published[1].metadata.at("figure"), "7");
}

TEST_F(LoopEventsTest, DoesNotTakeTheFirstSampleForAChange) {
  Consume({At(1, State::kReady)});
  EXPECT_TRUE(Published().empty());
}

TEST_F(LoopEventsTest, TellsTicksThatNeverRanFromSamplesThatWereLost) {
  Consume({At(2000, State::kIdle), At(2010, State::kIdle, 3)});
  const std::vector<Event> published = Published();
  ASSERT_EQ(published.size(), 2);
  EXPECT_EQ(published[0].kind, EventKind::kTicksMissed);
  EXPECT_EQ(published[0].metadata.at("ticks"), "3");
  EXPECT_EQ(published[1].kind, EventKind::kSamplesDropped);
  EXPECT_EQ(published[1].metadata.at("ticks"), "6");
}

TEST_F(LoopEventsTest, GathersAbsencesOfASecondIntoOneEvent) {
  SampleBlock samples;
  for (uint64_t tick = 2000; tick < 4000; tick += 2) {
    samples.push_back(At(tick, State::kIdle, tick / 2));
  }
  Consume(samples);
  const std::vector<Event> published = Published();
  ASSERT_EQ(published.size(), 2);
  EXPECT_EQ(published[0].metadata.at("ticks"), "1");
  EXPECT_EQ(published[1].metadata.at("ticks"), "500");
}

TEST_F(LoopEventsTest, DatesOtherEventsByTheNewestTick) {
  Consume({At(1, State::kIdle), At(2, State::kIdle)});
  log_.Publish(EventKind::kMassSet, "a mass");
  EXPECT_EQ(Published().at(0).tick, 2);
}

}  // namespace
}  // namespace mwidth::record
