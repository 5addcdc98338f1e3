// A client's stream of samples, and a server whose samples are the test's.
#pragma once

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

#include "mwidth/v1/telemetry.grpc.pb.h"
#include "server/exchange/clock.h"
#include "server/exchange/crossing.h"
#include "server/gate/axis_gate.h"
#include "server/record/broadcast.h"
#include "server/record/event_log.h"
#include "server/rpc/axis_registry.h"
#include "server/rpc/sample_encoding.h"
#include "server/rpc/telemetry_service.h"
#include "tests/server/gate/axis_fixture.h"

namespace mwidth::rpc {

inline constexpr std::size_t kMaxStreams = 20;
inline constexpr std::size_t kMaxQueuedSamples = 2000;

/// The client's end of one stream, and its account of the ticks that it got.
class Stream {
 public:
  Stream(v1::TelemetryService::Stub& stub, const v1::StreamSamplesRequest& request)
      : reader_(stub.StreamSamples(&context_, request)) {
    reader_->WaitForInitialMetadata();
  }

  /// The next batch, checked to follow the one before; nothing when the stream is over.
  const v1::SampleBatch* Read() {
    if (!reader_->Read(&response_)) {
      return nullptr;
    }
    const v1::SampleBatch& batch = response_.batch();
    const uint64_t absent = batch.missed_ticks_before() + batch.dropped_ticks_before();
    if (received_ > 0 && batch.decimation() == 1) {
      EXPECT_EQ(batch.first_tick(), next_tick_ + absent);
    }
    received_ += static_cast<uint64_t>(batch.position_size());
    absent_ += absent;
    next_tick_ = batch.first_tick() + batch.decimation() * static_cast<uint64_t>(batch.position_size());
    return &batch;
  }

  void ReadUpTo(uint64_t next_tick) {
    while (next_tick_ < next_tick) {
      ASSERT_NE(Read(), nullptr);
    }
  }

  void Cancel() { context_.TryCancel(); }

  grpc::Status Finish() {
    while (Read() != nullptr) {
    }
    return reader_->Finish();
  }

  uint64_t next_tick() const { return next_tick_; }
  uint64_t received() const { return received_; }
  uint64_t absent() const { return absent_; }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReader<v1::StreamSamplesResponse>> reader_;
  v1::StreamSamplesResponse response_;
  uint64_t next_tick_ = 0;
  uint64_t received_ = 0;
  uint64_t absent_ = 0;
};

/// A server on a loopback port with one axis, whose samples are what a test consumes into the broadcast.
class TelemetryFixture : public testing::Test {
 protected:
  TelemetryFixture() {
    axes_.Add({.name = "elbow", .gate = gate_, .broadcast = broadcast_, .events = events_, .clock = clock_});
    grpc::ServerBuilder builder;
    int port = 0;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(&service_);
    service_.AddStreamsTo(streams_);
    streams_.AddTo(builder);
    server_ = builder.BuildAndStart();
    streams_.Start();
    channel_ = grpc::CreateChannel("127.0.0.1:" + std::to_string(port), grpc::InsecureChannelCredentials());
    stub_ = v1::TelemetryService::NewStub(channel_);
  }

  ~TelemetryFixture() override {
    server_->Shutdown(std::chrono::system_clock::now());
    streams_.Stop();
  }

  static v1::StreamSamplesRequest Request(uint32_t decimation, uint32_t max_batch, const std::string& axis) {
    v1::StreamSamplesRequest request;
    request.set_axis(axis);
    request.set_decimation(decimation);
    request.set_max_batch(max_batch);
    return request;
  }

  Stream Open(const v1::StreamSamplesRequest& request) { return {*stub_, request}; }

  Stream Open(uint32_t decimation = 0, uint32_t max_batch = 0, const std::string& axis = "") {
    return {*stub_, Request(decimation, max_batch, axis)};
  }

  grpc::Status Refusal(uint32_t decimation, uint32_t max_batch, const std::string& axis = "") {
    return Open(decimation, max_batch, axis).Finish();
  }

  grpc::Status Refusal(const v1::StreamSamplesRequest& request) { return Open(request).Finish(); }

  void AwaitSubscribers(std::size_t count) const {
    while (broadcast_.subscribers() != count) {
      std::this_thread::yield();
    }
  }

  const std::unique_ptr<exchange::Crossing> crossing_ = std::make_unique<exchange::Crossing>();
  exchange::MonotonicClock clock_;
  gate::AxisGate gate_{gate::PaperAxis(), *crossing_, clock_};
  record::Broadcast broadcast_{SampleEncoding("elbow"),
                               {.max_subscribers = kMaxStreams, .max_queued_samples = kMaxQueuedSamples}};
  record::EventLog events_{clock_};
  AxisRegistry axes_;
  TelemetryService service_{axes_};
  StreamThread streams_;
  std::unique_ptr<grpc::Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::TelemetryService::Stub> stub_;
};

}  // namespace mwidth::rpc
