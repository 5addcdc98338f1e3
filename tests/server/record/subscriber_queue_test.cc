#include "server/record/subscriber_queue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>

#include "tests/server/record/samples.h"

namespace mwidth::record {
namespace {

using testing::SizeIs;

std::shared_ptr<const EncodedBatch> BatchOf(uint64_t first_tick, std::size_t samples, uint64_t missed = 0,
                                            uint64_t dropped = 0, uint32_t decimation = 1) {
  return std::make_shared<const EncodedBatch>(EncodedBatch{.first_tick = first_tick,
                                                           .decimation = decimation,
                                                           .samples = samples,
                                                           .missed_ticks_before = missed,
                                                           .dropped_ticks_before = dropped,
                                                           .bytes = {}});
}

class SubscriberQueueTest : public testing::Test {
 protected:
  SubscriberQueue queue_{{.max_batch = 10, .max_samples = 20}, [] {}, false};
  Delivery delivery_;
};

TEST_F(SubscriberQueueTest, JoinsWhatWaitsUpToTheLimitOfABatch) {
  for (const uint64_t tick : {0, 4, 8, 12}) {
    queue_.Offer(BatchOf(tick, 4));
  }
  ASSERT_TRUE(queue_.Take(delivery_));
  EXPECT_THAT(delivery_.batches, SizeIs(2));
  EXPECT_EQ(delivery_.samples(), 8);
  EXPECT_FALSE(delivery_.as_encoded());
  ASSERT_TRUE(queue_.Take(delivery_));
  EXPECT_EQ(delivery_.first_tick(), 8);
  EXPECT_FALSE(queue_.Take(delivery_));
}

TEST_F(SubscriberQueueTest, ASingleBatchIsSentAsItIs) {
  queue_.Offer(BatchOf(0, 4, 1, 2));
  ASSERT_TRUE(queue_.Take(delivery_));
  EXPECT_TRUE(delivery_.as_encoded());
  EXPECT_EQ(delivery_.missed_ticks_before, 1);
  EXPECT_EQ(delivery_.dropped_ticks_before, 2);
}

TEST_F(SubscriberQueueTest, JoinsNothingAcrossAGap) {
  queue_.Offer(BatchOf(0, 2));
  queue_.Offer(BatchOf(5, 2, 3, 0));
  queue_.Offer(BatchOf(7, 2));
  ASSERT_TRUE(queue_.Take(delivery_));
  EXPECT_EQ(delivery_.samples(), 2);
  ASSERT_TRUE(queue_.Take(delivery_));
  EXPECT_EQ(delivery_.samples(), 4);
  EXPECT_EQ(delivery_.missed_ticks_before, 3);
}

TEST_F(SubscriberQueueTest, TellsTheTicksOfLostBatchesAndTheGapsThatTheyTold) {
  queue_.Offer(BatchOf(0, 2, 0, 0, 10));
  queue_.Offer(BatchOf(20, 18, 0, 0, 10));
  queue_.Offer(BatchOf(205, 3, 4, 1, 10));
  queue_.Offer(BatchOf(240, 2, 3, 2, 10));
  ASSERT_TRUE(queue_.Take(delivery_));
  ASSERT_TRUE(queue_.Take(delivery_));
  queue_.Offer(BatchOf(260, 1, 1, 0, 10));
  ASSERT_TRUE(queue_.Take(delivery_));
  EXPECT_EQ(delivery_.missed_ticks_before, 4 + 3 + 1);
  EXPECT_EQ(delivery_.dropped_ticks_before, 30 + 1 + 20 + 2);
  EXPECT_FALSE(delivery_.as_encoded());
}

TEST_F(SubscriberQueueTest, AnEmptyQueueTakesABatchLargerThanItsLimit) {
  queue_.Offer(BatchOf(0, 500));
  queue_.Offer(BatchOf(500, 1));
  ASSERT_TRUE(queue_.Take(delivery_));
  EXPECT_EQ(delivery_.samples(), 500);
  EXPECT_FALSE(queue_.Take(delivery_));
  queue_.Offer(BatchOf(501, 1));
  ASSERT_TRUE(queue_.Take(delivery_));
  EXPECT_EQ(delivery_.dropped_ticks_before, 1);
}

TEST_F(SubscriberQueueTest, FindsItsFirstSampleInABatch) {
  const SubscriberQueue queue(
      {.first_tick = 95, .max_batch = 1, .max_samples = 1}, [] {}, false);
  const auto first_of = [&](uint64_t first_tick, uint32_t decimation) {
    Batch batch;
    batch.first_tick = first_tick;
    batch.decimation = decimation;
    return queue.FirstSampleOf(batch);
  };
  EXPECT_EQ(first_of(90, 1), 5);
  EXPECT_EQ(first_of(95, 1), 0);
  EXPECT_EQ(first_of(100, 1), 0);
  EXPECT_EQ(first_of(80, 10), 2);
  EXPECT_EQ(first_of(85, 10), 1);
}

TEST_F(SubscriberQueueTest, EndsOnceEverythingIsTaken) {
  queue_.Offer(BatchOf(0, 1));
  queue_.Close();
  EXPECT_FALSE(queue_.ended());
  ASSERT_TRUE(queue_.Take(delivery_));
  EXPECT_TRUE(queue_.ended());
}

}  // namespace
}  // namespace mwidth::record
