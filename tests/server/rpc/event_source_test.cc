#include "server/rpc/event_source.h"

#include <chrono>
#include <memory>
#include <optional>
#include <vector>

#include "tests/server/rpc/served_axis.h"
#include "tests/server/rpc/telemetry_fixture.h"

namespace mwidth::rpc {
namespace {

using record::EventKind;

class EventSourceTest : public TelemetryFixture {
 protected:
  struct Call {
    grpc::ClientContext context;
    std::unique_ptr<grpc::ClientReader<v1::StreamEventsResponse>> reader;

    v1::StreamEventsResponse Read() {
      v1::StreamEventsResponse response;
      EXPECT_TRUE(reader->Read(&response));
      return response;
    }
    grpc::Status Finish() {
      v1::StreamEventsResponse response;
      while (reader->Read(&response)) {
      }
      return reader->Finish();
    }
  };

  std::unique_ptr<Call> Open(std::optional<uint64_t> after = std::nullopt, const std::string& axis = "") {
    v1::StreamEventsRequest request;
    request.set_axis(axis);
    if (after) {
      request.set_after_number(*after);
    }
    auto call = std::make_unique<Call>();
    call->context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(20));
    call->reader = stub_->StreamEvents(&call->context, request);
    call->reader->WaitForInitialMetadata();
    return call;
  }

  ~EventSourceTest() override { events_.Close(); }
};

TEST_F(EventSourceTest, SendsWhatHappensFromNowOn) {
  events_.Publish(EventKind::kStateChanged, "before");
  const auto call = Open();
  events_.Publish(EventKind::kMassSet, "after", {{"mass", "0.5"}}, 12);
  const v1::Event event = call->Read().event();
  EXPECT_EQ(event.axis(), "elbow");
  EXPECT_EQ(event.number(), 2);
  EXPECT_EQ(event.kind(), v1::EVENT_KIND_MASS_SET);
  EXPECT_EQ(event.tick(), 12);
  EXPECT_EQ(event.message(), "after");
  EXPECT_EQ(event.metadata().at("mass"), "0.5");
}

TEST_F(EventSourceTest, GoesOnWhereAReaderLeftOff) {
  for (int i = 0; i < 3; ++i) {
    events_.Publish(EventKind::kStateChanged, "one of three");
  }
  EXPECT_EQ(Open(1)->Read().event().number(), 2);
  EXPECT_EQ(Open(0)->Read().event().number(), 1);
}

TEST_F(EventSourceTest, TellsWhatAReaderLost) {
  for (std::size_t i = 0; i < record::EventLog::kRemembered + 7; ++i) {
    events_.Publish(EventKind::kStateChanged, "one of many");
  }
  const v1::StreamEventsResponse response = Open(2)->Read();
  EXPECT_EQ(response.lost_before(), 5);
  EXPECT_EQ(response.event().number(), 8);
}

TEST_F(EventSourceTest, EndsWhenTheServerDoes) {
  const auto call = Open();
  events_.Publish(EventKind::kServerStopping, "the last one");
  events_.Close();
  EXPECT_EQ(call->Read().event().message(), "the last one");
  ExpectStatus(call->Finish(), grpc::StatusCode::UNAVAILABLE, "SHUTTING_DOWN");
}

TEST_F(EventSourceTest, IsOneOfALimitedNumber) {
  std::vector<std::unique_ptr<Call>> calls;
  for (std::size_t i = 0; i < kMaxEventStreams; ++i) {
    calls.push_back(Open());
  }
  ExpectStatus(Open()->Finish(), grpc::StatusCode::RESOURCE_EXHAUSTED, "TOO_MANY_STREAMS");
}

TEST_F(EventSourceTest, RefusesAnUnknownAxis) {
  ExpectStatus(Open(std::nullopt, "knee")->Finish(), grpc::StatusCode::NOT_FOUND, "UNKNOWN_AXIS");
}

TEST_F(EventSourceTest, TheClockIsTheOneThatDatesSamples) {
  v1::SyncClockRequest request;
  request.set_client_send_ns(-17);
  v1::SyncClockResponse response;
  grpc::ClientContext context;
  const int64_t before_ns = clock_.NowNs();
  ASSERT_TRUE(stub_->SyncClock(&context, request, &response).ok());
  EXPECT_EQ(response.client_send_ns(), -17);
  EXPECT_LE(before_ns, response.server_receive_ns());
  EXPECT_LE(response.server_receive_ns(), response.server_send_ns());
  EXPECT_LE(response.server_send_ns(), clock_.NowNs());
  EXPECT_GT(response.wall_time().seconds(), 1'700'000'000);
}

}  // namespace
}  // namespace mwidth::rpc
