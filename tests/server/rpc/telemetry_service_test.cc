#include "server/rpc/telemetry_service.h"

#include <gmock/gmock.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "mwidth/v1/telemetry.pb.h"
#include "server/exchange/crossing.h"
#include "tests/server/record/samples.h"
#include "tests/server/rpc/served_axis.h"
#include "tests/server/rpc/telemetry_fixture.h"

namespace mwidth::rpc {
namespace {

using record::BlockOf;
using testing::ElementsAre;

using TelemetryServiceTest = TelemetryFixture;

TEST_F(TelemetryServiceTest, StreamsEveryColumnOfASample) {
  exchange::Sample sample;
  sample.tick = 41;
  sample.monotonic_ns = -2;
  sample.position_counts = -3;
  sample.force_counts = -4;
  sample.acceleration_counts = -5;
  sample.state = exchange::State::kRendering;
  sample.saturated = true;
  sample.position_stale = true;
  sample.force_taken = true;
  sample.position = 0.5;
  sample.velocity = 0.6;
  sample.acceleration = 0.7;
  sample.force = 0.8;
  sample.mass = 0.9;
  exchange::Sample next;
  next.tick = 42;
  Stream stream = Open();
  broadcast_.Consume(std::make_shared<record::SampleBlock>(record::SampleBlock{sample, next}));
  const v1::SampleBatch* batch = stream.Read();
  ASSERT_NE(batch, nullptr);
  EXPECT_EQ(batch->axis(), "elbow");
  EXPECT_EQ(batch->reduction(), v1::REDUCTION_PICK);
  EXPECT_EQ(batch->position_min_size(), 0);
  EXPECT_EQ(batch->first_tick(), 41);
  EXPECT_EQ(batch->decimation(), 1);
  EXPECT_THAT(batch->monotonic_ns(), ElementsAre(-2, 0));
  EXPECT_THAT(batch->position(), ElementsAre(0.5, 0));
  EXPECT_THAT(batch->velocity(), ElementsAre(0.6, 0));
  EXPECT_THAT(batch->acceleration(), ElementsAre(0.7, 0));
  EXPECT_THAT(batch->force(), ElementsAre(0.8, 0));
  EXPECT_THAT(batch->mass(), ElementsAre(0.9, 0));
  EXPECT_THAT(batch->state(), ElementsAre(v1::STATE_RENDERING, v1::STATE_IDLE));
  EXPECT_THAT(batch->saturated(), ElementsAre(true, false));
  EXPECT_THAT(batch->position_stale(), ElementsAre(true, false));
  EXPECT_THAT(batch->position_counts(), ElementsAre(-3, 0));
  EXPECT_THAT(batch->force_counts(), ElementsAre(-4, 0));
  EXPECT_THAT(batch->acceleration_counts(), ElementsAre(-5, 0));
  EXPECT_THAT(batch->force_taken(), ElementsAre(true, false));
}

TEST_F(TelemetryServiceTest, SendsTicksThatAreMultiplesOfTheDecimation) {
  Stream stream = Open(10);
  broadcast_.Consume(BlockOf(95, 30));
  const v1::SampleBatch* batch = stream.Read();
  ASSERT_NE(batch, nullptr);
  EXPECT_EQ(batch->first_tick(), 100);
  EXPECT_EQ(batch->decimation(), 10);
  EXPECT_EQ(batch->position_size(), 3);
}

TEST_F(TelemetryServiceTest, KeepsBatchesWithinTheirLimit) {
  Stream stream = Open(1, 10);
  broadcast_.Consume(BlockOf(1, 95));
  while (stream.next_tick() < 96) {
    const v1::SampleBatch* batch = stream.Read();
    ASSERT_NE(batch, nullptr);
    EXPECT_LE(batch->position_size(), 10);
  }
}

TEST_F(TelemetryServiceTest, RefusesNumbersOutOfRange) {
  ExpectStatus(Refusal(0, 1001), grpc::StatusCode::INVALID_ARGUMENT, "INVALID_NUMBER");
  const grpc::Status decimation = Refusal(10'001, 0);
  ExpectStatus(decimation, grpc::StatusCode::INVALID_ARGUMENT, "INVALID_NUMBER");
  EXPECT_THAT(decimation.error_message(), testing::HasSubstr("0 to 10000"));
  EXPECT_EQ(broadcast_.subscribers(), 0);
  Stream largest = Open(10'000, 1000, "elbow");
  EXPECT_EQ(broadcast_.subscribers(), 1);
}

TEST_F(TelemetryServiceTest, RefusesBatchSizesAndReductionsThatCannotBe) {
  v1::StreamSamplesRequest request;
  request.set_min_batch(1001);
  ExpectStatus(Refusal(request), grpc::StatusCode::INVALID_ARGUMENT, "INVALID_NUMBER");
  request.set_min_batch(11);
  request.set_max_batch(10);
  const grpc::Status crossed = Refusal(request);
  ExpectStatus(crossed, grpc::StatusCode::INVALID_ARGUMENT, "INVALID_NUMBER");
  EXPECT_THAT(crossed.error_message(), testing::HasSubstr("at most max_batch, which is 10"));
  request.Clear();
  request.set_reduction(static_cast<v1::Reduction>(4));
  ExpectStatus(Refusal(request), grpc::StatusCode::INVALID_ARGUMENT, "INVALID_NUMBER");
  request.set_reduction(v1::REDUCTION_LOW_PASS);
  request.set_decimation(1001);
  const grpc::Status filtered = Refusal(request);
  ExpectStatus(filtered, grpc::StatusCode::INVALID_ARGUMENT, "INVALID_NUMBER");
  EXPECT_THAT(filtered.error_message(), testing::HasSubstr("0 to 1000"));
  EXPECT_EQ(broadcast_.subscribers(), 0);
  request.set_decimation(1000);
  request.set_min_batch(1000);
  Stream largest = Open(request);
  EXPECT_EQ(broadcast_.subscribers(), 1);
}

TEST_F(TelemetryServiceTest, SendsExtremesWithEachSampleOfTheTicksSinceTheOneBefore) {
  auto block = std::make_shared<record::SampleBlock>();
  for (uint64_t tick = 1; tick <= 20; ++tick) {
    block->push_back(record::SampleAt(tick));
    block->back().position = static_cast<double>(tick);
    block->back().force = -static_cast<double>(tick);
  }
  v1::StreamSamplesRequest request;
  request.set_decimation(10);
  request.set_reduction(v1::REDUCTION_MIN_MAX);
  Stream stream = Open(request);
  broadcast_.Consume(block);
  const v1::SampleBatch* batch = stream.Read();
  ASSERT_NE(batch, nullptr);
  EXPECT_EQ(batch->reduction(), v1::REDUCTION_MIN_MAX);
  EXPECT_THAT(batch->position(), ElementsAre(10, 20));
  EXPECT_THAT(batch->position_min(), ElementsAre(1, 11));
  EXPECT_THAT(batch->position_max(), ElementsAre(10, 20));
  EXPECT_THAT(batch->force_min(), ElementsAre(-10, -20));
  EXPECT_THAT(batch->force_max(), ElementsAre(-1, -11));
  EXPECT_THAT(batch->velocity_min(), ElementsAre(0, 0));
  EXPECT_THAT(batch->acceleration_max(), ElementsAre(0, 0));
}

TEST_F(TelemetryServiceTest, SendsALowPassedStreamCentredOnItsTicks) {
  auto block = std::make_shared<record::SampleBlock>();
  for (uint64_t tick = 1; tick <= 400; ++tick) {
    block->push_back(record::SampleAt(tick));
    // A ramp, which a filter without delay leaves as it is; and what it must take away.
    block->back().position = 0.01 * static_cast<double>(tick) + (tick % 2 == 0 ? 1 : -1);
  }
  v1::StreamSamplesRequest request;
  request.set_decimation(4);
  request.set_reduction(v1::REDUCTION_LOW_PASS);
  Stream stream = Open(request);
  broadcast_.Consume(block);
  const v1::SampleBatch* batch = stream.Read();
  ASSERT_NE(batch, nullptr);
  EXPECT_EQ(batch->reduction(), v1::REDUCTION_LOW_PASS);
  EXPECT_EQ(batch->first_tick() % 4, 0);
  EXPECT_GT(batch->first_tick(), 100);
  ASSERT_GT(batch->position_size(), 40);
  for (int i = 0; i < batch->position_size(); ++i) {
    EXPECT_NEAR(batch->position(i),
                0.01 * static_cast<double>(batch->first_tick() + 4 * static_cast<uint64_t>(i)), 2e-4);
  }
}

TEST_F(TelemetryServiceTest, RefusesAnUnknownAxis) {
  ExpectStatus(Refusal(0, 0, "knee"), grpc::StatusCode::NOT_FOUND, "UNKNOWN_AXIS");
}

TEST_F(TelemetryServiceTest, RefusesBytesThatAreNoRequest) {
  grpc::GenericStub stub(channel_);
  grpc::ClientContext context;
  grpc::CompletionQueue queue;
  const auto call = stub.PrepareCall(&context, "/mwidth.v1.TelemetryService/StreamSamples", &queue);
  const auto await = [&queue] {
    void* tag = nullptr;
    bool ok = false;
    return queue.Next(&tag, &ok) && ok;
  };
  call->StartCall(nullptr);
  ASSERT_TRUE(await());
  const grpc::Slice garbage(std::string("\xff\xff\xff\xff"));
  call->WriteLast(grpc::ByteBuffer(&garbage, 1), grpc::WriteOptions(), nullptr);
  ASSERT_TRUE(await());
  grpc::Status status;
  call->Finish(&status, nullptr);
  ASSERT_TRUE(await());
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INTERNAL);
}

}  // namespace
}  // namespace mwidth::rpc
