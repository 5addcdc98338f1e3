#include "server/record/batch_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/record/samples.h"

namespace mwidth::record {
namespace {

using testing::SizeIs;

class BatchReaderTest : public testing::Test {
 protected:
  BatchReader Reader(uint32_t decimation, std::size_t max_batch) {
    return {broadcast_.Subscribe([] {}), Batcher(decimation, max_batch)};
  }

  Broadcast broadcast_{{.max_queued_samples = 20}};
  Batch batch_;
};

TEST_F(BatchReaderTest, JoinsTheBlocksThatWait) {
  BatchReader reader = Reader(1, 100);
  broadcast_.Consume(BlockOf(0, 5));
  broadcast_.Consume(BlockOf(5, 5));
  ASSERT_TRUE(reader.Next(batch_));
  EXPECT_THAT(batch_.samples, SizeIs(10));
  EXPECT_FALSE(reader.Next(batch_));
}

TEST_F(BatchReaderTest, HoldsNothingBackForAFullerBatch) {
  BatchReader reader = Reader(1, 100);
  broadcast_.Consume(BlockOf(0, 1));
  ASSERT_TRUE(reader.Next(batch_));
  EXPECT_THAT(batch_.samples, SizeIs(1));
}

TEST_F(BatchReaderTest, ContinuesInTheMiddleOfABlock) {
  BatchReader reader = Reader(1, 4);
  broadcast_.Consume(BlockOf(0, 6));
  ASSERT_TRUE(reader.Next(batch_));
  broadcast_.Consume(BlockOf(6, 1));
  ASSERT_TRUE(reader.Next(batch_));
  EXPECT_EQ(batch_.first_tick, 4);
  EXPECT_THAT(batch_.samples, SizeIs(3));
}

TEST_F(BatchReaderTest, HasNoBatchWhereTheDecimationSelectsNothing) {
  BatchReader reader = Reader(10, 100);
  broadcast_.Consume(BlockOf(1, 9));
  EXPECT_FALSE(reader.Next(batch_));
  broadcast_.Consume(BlockOf(10, 1));
  ASSERT_TRUE(reader.Next(batch_));
  EXPECT_EQ(batch_.first_tick, 10);
}

TEST_F(BatchReaderTest, TellsWhatItsQueueDropped) {
  BatchReader reader = Reader(1, 100);
  broadcast_.Consume(BlockOf(0, 20));
  broadcast_.Consume(BlockOf(20, 9));
  ASSERT_TRUE(reader.Next(batch_));
  broadcast_.Consume(BlockOf(29, 1));
  ASSERT_TRUE(reader.Next(batch_));
  EXPECT_EQ(batch_.first_tick, 29);
  EXPECT_EQ(batch_.dropped_ticks_before, 9);
  EXPECT_EQ(batch_.missed_ticks_before, 0);
}

TEST_F(BatchReaderTest, EndsAfterTheLastBatchOfAClosedBroadcast) {
  BatchReader reader = Reader(1, 4);
  broadcast_.Consume(BlockOf(0, 6));
  broadcast_.Close();
  ASSERT_TRUE(reader.Next(batch_));
  EXPECT_FALSE(reader.ended());
  ASSERT_TRUE(reader.Next(batch_));
  EXPECT_FALSE(reader.Next(batch_));
  EXPECT_TRUE(reader.ended());
}

}  // namespace
}  // namespace mwidth::record
