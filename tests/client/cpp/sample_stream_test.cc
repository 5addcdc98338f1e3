#include "client/cpp/sample_stream.h"

#include <gtest/gtest.h>

#include <thread>

#include "client/cpp/client.h"
#include "tests/client/fake_server.h"

namespace mwidth::client {
namespace {

using mwidth::testing::FakeServer;

TEST(SampleStreamTest, ReturnsBatchesInOrderAndCountsTheirGaps) {
  const FakeServer server;
  auto stream = Client::Connect(server.address()).Stream("", 1, 10);
  EXPECT_EQ(stream.Next()->first_tick(), 1000u);
  EXPECT_EQ(stream.Next()->first_tick(), 1010u);
  EXPECT_EQ(stream.gaps().Total(), 0u);
  EXPECT_EQ(stream.Next()->first_tick(), 1025u);
  EXPECT_EQ(stream.gaps().missed_ticks, 2u);
  EXPECT_EQ(stream.gaps().dropped_ticks, 3u);
  EXPECT_EQ(stream.gaps().Total(), 5u);
}

TEST(SampleStreamTest, AsksForTheDecimationAndBatchThatWereGiven) {
  const FakeServer server;
  auto stream = Client::Connect(server.address()).Stream("elbow", 7, 4);
  const auto batch = stream.Next();
  EXPECT_EQ(batch->decimation(), 7u);
  EXPECT_EQ(batch->position_size(), 4);
}

TEST(SampleStreamTest, CancelEndsItWithoutAnError) {
  const FakeServer server;
  auto stream = Client::Connect(server.address()).Stream();
  ASSERT_TRUE(stream.Next().has_value());
  stream.Cancel();
  EXPECT_FALSE(stream.Next().has_value());
  EXPECT_FALSE(stream.Next().has_value());
}

TEST(SampleStreamTest, CancelFromAnotherThreadWakesAReader) {
  const FakeServer server;
  auto stream = Client::Connect(server.address()).Stream();
  std::jthread canceller([&stream] { stream.Cancel(); });
  while (stream.Next()) {
  }
  EXPECT_FALSE(stream.Next().has_value());
}

TEST(SampleStreamTest, AnEndByTheServerIsAnError) {
  FakeServer server;
  server.Behave({.end_stream_after_batches = 1});
  auto stream = Client::Connect(server.address()).Stream();
  EXPECT_TRUE(stream.Next().has_value());
  EXPECT_THROW(stream.Next(), Error);
}

TEST(SampleStreamTest, AnUnknownAxisIsAnErrorOfTheFirstNext) {
  const FakeServer server;
  auto stream = Client::Connect(server.address()).Stream("knee");
  EXPECT_THROW(stream.Next(), Error);
}

}  // namespace
}  // namespace mwidth::client
