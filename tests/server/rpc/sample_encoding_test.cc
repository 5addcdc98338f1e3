#include "server/rpc/sample_encoding.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tests/server/record/samples.h"

namespace mwidth::rpc {
namespace {

using testing::ElementsAre;

std::shared_ptr<const record::EncodedBatch> Encoded(uint64_t first_tick, std::size_t count,
                                                    uint64_t missed = 0, uint64_t dropped = 0) {
  record::Batch batch;
  batch.first_tick = first_tick;
  batch.missed_ticks_before = missed;
  batch.dropped_ticks_before = dropped;
  for (std::size_t i = 0; i < count; ++i) {
    batch.samples.push_back(record::SampleAt(first_tick + i));
    batch.samples.back().position = static_cast<double>(first_tick + i);
  }
  return record::MakeEncoded(batch, SampleEncoding("elbow"));
}

/// As a client reads it.
v1::SampleBatch Parsed(const grpc::ByteBuffer& buffer) {
  std::vector<grpc::Slice> slices;
  EXPECT_TRUE(buffer.Dump(&slices).ok());
  std::string bytes;
  for (const grpc::Slice& slice : slices) {
    bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  }
  v1::StreamSamplesResponse response;
  EXPECT_TRUE(response.ParseFromString(bytes));
  return response.batch();
}

TEST(SampleEncodingTest, ABatchIsSentInItsOwnMemory) {
  const auto encoded = Encoded(5, 3);
  const grpc::ByteBuffer buffer = Assemble({.batches = {encoded}});
  std::vector<grpc::Slice> slices;
  ASSERT_TRUE(buffer.Dump(&slices).ok());
  ASSERT_EQ(slices.size(), 1);
  EXPECT_EQ(static_cast<const void*>(slices[0].begin()), encoded->bytes.data());
  EXPECT_THAT(Parsed(buffer).position(), ElementsAre(5, 6, 7));
}

TEST(SampleEncodingTest, TheMemoryLastsAsLongAsTheMessage) {
  auto encoded = Encoded(5, 3);
  const std::weak_ptr<const record::EncodedBatch> watched = encoded;
  {
    const grpc::ByteBuffer buffer = Assemble({.batches = {std::move(encoded)}});
    EXPECT_FALSE(watched.expired());
  }
  EXPECT_TRUE(watched.expired());
}

TEST(SampleEncodingTest, WhatOneSubscriberLostIsToldBehindTheSharedBytes) {
  const auto encoded = Encoded(5, 3, 2, 1);
  const v1::SampleBatch batch =
      Parsed(Assemble({.batches = {encoded}, .missed_ticks_before = 7, .dropped_ticks_before = 400}));
  EXPECT_EQ(batch.axis(), "elbow");
  EXPECT_EQ(batch.first_tick(), 5);
  EXPECT_EQ(batch.missed_ticks_before(), 7);
  EXPECT_EQ(batch.dropped_ticks_before(), 400);
  EXPECT_THAT(batch.position(), ElementsAre(5, 6, 7));
}

TEST(SampleEncodingTest, BatchesThatWaitedAreOneMessage) {
  const v1::SampleBatch batch = Parsed(Assemble({.batches = {Encoded(0, 2), Encoded(2, 3), Encoded(5, 1)}}));
  EXPECT_EQ(batch.first_tick(), 0) << "0 is written, too: it stands in place of 5";
  EXPECT_EQ(batch.decimation(), 1);
  EXPECT_EQ(batch.missed_ticks_before() + batch.dropped_ticks_before(), 0);
  EXPECT_THAT(batch.position(), ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_EQ(batch.state_size(), 6);
  EXPECT_EQ(batch.force_taken_size(), 6);
}

}  // namespace
}  // namespace mwidth::rpc
