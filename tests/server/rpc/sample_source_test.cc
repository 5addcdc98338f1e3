#include "server/rpc/sample_source.h"

#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "mwidth/v1/telemetry.pb.h"
#include "tests/server/record/samples.h"
#include "tests/server/rpc/served_axis.h"
#include "tests/server/rpc/telemetry_fixture.h"

namespace mwidth::rpc {
namespace {

using record::BlockOf;

using SampleSourceTest = TelemetryFixture;

TEST_F(SampleSourceTest, NumbersTicksConsecutivelyOverManyBatches) {
  std::mt19937 random(1);
  Stream stream = Open();
  uint64_t tick = 1000;
  for (int block = 0; block < 1000; ++block) {
    const std::size_t count = 1 + random() % 50;
    broadcast_.Consume(BlockOf(tick, count));
    tick += count;
    // Nothing is held back for a fuller batch: whatever has been consumed can be read.
    stream.ReadUpTo(tick);
  }
  EXPECT_EQ(stream.received(), tick - 1000);
  EXPECT_EQ(stream.absent(), 0);
}

TEST_F(SampleSourceTest, ReportsAGapExactly) {
  Stream stream = Open();
  broadcast_.Consume(BlockOf(1, 9));
  stream.ReadUpTo(10);
  broadcast_.Consume(BlockOf(17, 3, 5));
  const v1::SampleBatch* batch = stream.Read();
  ASSERT_NE(batch, nullptr);
  EXPECT_EQ(batch->first_tick(), 17);
  EXPECT_EQ(batch->missed_ticks_before(), 5);
  EXPECT_EQ(batch->dropped_ticks_before(), 2);
}

TEST_F(SampleSourceTest, ASlowReaderLosesSamplesAloneAndIsToldSo) {
  constexpr std::size_t kBlock = 500;
  Stream slow = Open();
  Stream fast = Open();
  uint64_t tick = 1;
  const auto consume = [&] {
    broadcast_.Consume(BlockOf(tick, kBlock));
    tick += kBlock;
    fast.ReadUpTo(tick);
  };
  // Several megabytes: far more than the transport's windows and the queue hold for a reader that does not
  // read.
  while (tick < 100'000) {
    consume();
  }
  std::atomic<bool> resumed = false;
  std::thread reader([&] {
    while (slow.absent() == 0) {
      ASSERT_NE(slow.Read(), nullptr);
    }
    resumed = true;
  });
  while (!resumed) {
    consume();
  }
  reader.join();
  EXPECT_GT(slow.absent(), 0);
  EXPECT_EQ(slow.received() + slow.absent(), slow.next_tick() - 1);
  EXPECT_EQ(fast.received(), tick - 1);
  EXPECT_EQ(fast.absent(), 0);
}

TEST_F(SampleSourceTest, HoldsSmallBatchesBackUntilTheyAreFullOrAGapOrTheEndComes) {
  v1::StreamSamplesRequest request;
  request.set_min_batch(20);
  request.set_max_batch(20);
  Stream stream = Open(request);
  for (uint64_t tick = 1; tick < 60; ++tick) {
    broadcast_.Consume(BlockOf(tick, 1));
  }
  broadcast_.Consume(BlockOf(65, 2));
  broadcast_.Close();
  std::vector<std::pair<uint64_t, int>> batches;
  while (const v1::SampleBatch* batch = stream.Read()) {
    batches.emplace_back(batch->first_tick(), batch->position_size());
  }
  // The first ends where all of this size do.
  EXPECT_THAT(batches,
              testing::ElementsAre(std::pair(1, 19), std::pair(20, 20), std::pair(40, 20), std::pair(65, 2)));
  EXPECT_EQ(stream.absent(), 5);
}

TEST_F(SampleSourceTest, StreamsOfOneCutAreSentTheSameBytes) {
  std::vector<std::unique_ptr<Stream>> streams;
  for (std::size_t i = 0; i < kMaxStreams; ++i) {
    streams.push_back(std::make_unique<Stream>(*stub_, Request(2, 0, "")));
  }
  EXPECT_EQ(broadcast_.groups(), 1);
  for (uint64_t tick = 1; tick < 1001; tick += 10) {
    broadcast_.Consume(BlockOf(tick, 10));
  }
  for (const auto& stream : streams) {
    stream->ReadUpTo(1001);
    EXPECT_EQ(stream->received(), 500);
    EXPECT_EQ(stream->absent(), 0);
  }
}

TEST_F(SampleSourceTest, RefusesMoreStreamsThanTheLimitUntilOneEnds) {
  std::vector<std::unique_ptr<Stream>> streams;
  for (std::size_t i = 0; i < kMaxStreams; ++i) {
    streams.push_back(std::make_unique<Stream>(*stub_, Request(0, 0, "")));
  }
  const grpc::Status refused = Refusal(0, 0);
  ExpectStatus(refused, grpc::StatusCode::RESOURCE_EXHAUSTED, "TOO_MANY_STREAMS");
  EXPECT_EQ(DetailsOf(refused).info.metadata().at("max_streams"), std::to_string(kMaxStreams));
  streams.back()->Cancel();
  EXPECT_EQ(streams.back()->Finish().error_code(), grpc::StatusCode::CANCELLED);
  AwaitSubscribers(kMaxStreams - 1);
  Stream late = Open();
  broadcast_.Consume(BlockOf(1, 1));
  EXPECT_NE(late.Read(), nullptr);
}

TEST_F(SampleSourceTest, EndsAStreamAfterItsLastSampleWhenTheBroadcastCloses) {
  Stream stream = Open(1, 10);
  broadcast_.Consume(BlockOf(1, 95));
  broadcast_.Close();
  const grpc::Status status = stream.Finish();
  EXPECT_EQ(stream.received(), 95);
  ExpectStatus(status, grpc::StatusCode::UNAVAILABLE, "SHUTTING_DOWN");
  EXPECT_EQ(Refusal(0, 0).error_code(), grpc::StatusCode::UNAVAILABLE);
}

TEST_F(SampleSourceTest, TheServerShutsDownUnderOpenStreams) {
  Stream idle = Open();
  Stream stuck = Open();
  for (uint64_t tick = 1; tick < 20'000; tick += 500) {
    broadcast_.Consume(BlockOf(tick, 500));
    idle.ReadUpTo(tick + 1);
  }
  server_->Shutdown(std::chrono::system_clock::now());
  streams_.Stop();
  EXPECT_EQ(broadcast_.subscribers(), 0);
  EXPECT_FALSE(stuck.Finish().ok());
}

TEST_F(SampleSourceTest, AccountsForEveryTickWhileTwentySubscribersComeAndGo) {
  std::atomic<std::size_t> visitors = kMaxStreams;
  std::vector<std::thread> threads;
  threads.reserve(kMaxStreams);
  for (std::size_t seed = 0; seed < kMaxStreams; ++seed) {
    threads.emplace_back([this, seed, &visitors] {
      std::mt19937 random(static_cast<std::mt19937::result_type>(seed));
      for (int visit = 0; visit < 5; ++visit) {
        Stream stream = Open(1, static_cast<uint32_t>(1 + random() % 100));
        const auto batches = random() % 30;
        for (std::size_t batch = 0; batch < batches; ++batch) {
          // Refused, while the server still takes leave of a stream that this thread has cancelled.
          if (stream.Read() == nullptr) {
            EXPECT_EQ(stream.Finish().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
            break;
          }
        }
        stream.Cancel();
      }
      --visitors;
    });
  }
  uint64_t tick = 1;
  while (visitors > 0) {
    broadcast_.Consume(BlockOf(tick, 5));
    tick += 5;
    std::this_thread::yield();
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  AwaitSubscribers(0);
}

}  // namespace
}  // namespace mwidth::rpc
