// The client's clocks, events and sessions, against services that answer as mwidthd's do.
#include <gmock/gmock.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/server_builder.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "client/cpp/client.h"

namespace mwidth::client {
namespace {

using ::testing::ElementsAre;

int64_t NowNs() { return std::chrono::steady_clock::now().time_since_epoch().count(); }

// A clock that is 5 s ahead of the client's.
class Telemetry final : public v1::TelemetryService::Service {
 public:
  static constexpr int64_t kAheadNs = 5'000'000'000;

  grpc::Status SyncClock(grpc::ServerContext*, const v1::SyncClockRequest* request,
                         v1::SyncClockResponse* response) override {
    response->set_client_send_ns(request->client_send_ns());
    response->set_server_receive_ns(NowNs() + kAheadNs);
    response->set_server_send_ns(NowNs() + kAheadNs);
    return grpc::Status::OK;
  }
  grpc::Status StreamEvents(grpc::ServerContext*, const v1::StreamEventsRequest* request,
                            grpc::ServerWriter<v1::StreamEventsResponse>* writer) override {
    for (uint64_t number = request->after_number() + 1; number < 1000; ++number) {
      v1::StreamEventsResponse response;
      response.mutable_event()->set_number(number);
      if (!writer->Write(response)) {
        return grpc::Status::CANCELLED;
      }
    }
    return {grpc::StatusCode::UNAVAILABLE, "the server shuts down"};
  }
};

class Sessions final : public v1::SessionService::Service {
 public:
  grpc::Status StartSession(grpc::ServerContext*, const v1::StartSessionRequest* request,
                            v1::StartSessionResponse* response) override {
    response->mutable_session()->set_session_id(request->axis() + "_" + request->labels().subject());
    return grpc::Status::OK;
  }
  grpc::Status EndSession(grpc::ServerContext*, const v1::EndSessionRequest* request,
                          v1::EndSessionResponse* response) override {
    if (request->session_id() != "elbow_01") {
      return {grpc::StatusCode::NOT_FOUND, "no such session"};
    }
    response->mutable_session()->set_state(v1::SESSION_STATE_ENDED);
    return grpc::Status::OK;
  }
  grpc::Status AddMarker(grpc::ServerContext*, const v1::AddMarkerRequest* request,
                         v1::AddMarkerResponse* response) override {
    response->mutable_marker()->set_label(request->label());
    return grpc::Status::OK;
  }
  grpc::Status ListSessions(grpc::ServerContext*, const v1::ListSessionsRequest*,
                            v1::ListSessionsResponse* response) override {
    response->add_sessions()->set_session_id("elbow_01");
    return grpc::Status::OK;
  }
  grpc::Status GetSession(grpc::ServerContext*, const v1::GetSessionRequest* request,
                          v1::GetSessionResponse* response) override {
    response->mutable_session()->set_session_id(request->session_id());
    return grpc::Status::OK;
  }
  grpc::Status ReadSession(grpc::ServerContext*, const v1::ReadSessionRequest* request,
                           grpc::ServerWriter<v1::ReadSessionResponse>* writer) override {
    for (uint64_t tick = request->first_tick(); tick <= request->last_tick(); ++tick) {
      v1::ReadSessionResponse response;
      response.mutable_batch()->set_first_tick(tick);
      writer->Write(response);
    }
    return grpc::Status::OK;
  }
};

class SessionsTest : public ::testing::Test {
 protected:
  SessionsTest() {
    int port = 0;
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(&telemetry_);
    builder.RegisterService(&sessions_);
    server_ = builder.BuildAndStart();
    client_ = std::make_unique<Client>(Client::Connect("127.0.0.1:" + std::to_string(port)));
  }

  Telemetry telemetry_;
  Sessions sessions_;
  std::unique_ptr<grpc::Server> server_;
  std::unique_ptr<Client> client_;
};

TEST_F(SessionsTest, FindsTheServersClockToWithinItsBound) {
  const ClockOffset offset = client_->SyncClock();
  EXPECT_GT(offset.error.count(), 0);
  EXPECT_LE(std::chrono::abs(offset.offset - std::chrono::nanoseconds(Telemetry::kAheadNs)), offset.error);
}

TEST_F(SessionsTest, WatchesEventsUntilThereIsEnough) {
  v1::StreamEventsRequest request;
  request.set_after_number(3);
  std::vector<uint64_t> numbers;
  client_->WatchEvents(request, [&](const v1::StreamEventsResponse& response) {
    numbers.push_back(response.event().number());
    return numbers.size() < 3;
  });
  EXPECT_THAT(numbers, ElementsAre(4, 5, 6));
}

TEST_F(SessionsTest, ThrowsWhereTheServerEndsTheEvents) {
  EXPECT_THROW(client_->WatchEvents({}, [](const auto&) { return true; }), Error);
}

TEST_F(SessionsTest, BeginsMarksEndsAndListsSessions) {
  v1::SessionLabels labels;
  labels.set_subject("01");
  const std::string id = client_->StartSession(labels, "elbow").session_id();
  EXPECT_EQ(id, "elbow_01");
  v1::AddMarkerRequest marker;
  marker.set_label("here");
  EXPECT_EQ(client_->AddMarker(marker).label(), "here");
  EXPECT_EQ(client_->EndSession(id).state(), v1::SESSION_STATE_ENDED);
  EXPECT_EQ(client_->ListSessions().sessions(0).session_id(), id);
  EXPECT_EQ(client_->GetSession(id).session().session_id(), id);
  EXPECT_THROW(client_->EndSession("none"), Error);
}

TEST_F(SessionsTest, ReadsASessionWholeOrUntilThereIsEnough) {
  v1::ReadSessionRequest request;
  request.set_first_tick(10);
  request.set_last_tick(14);
  std::vector<uint64_t> ticks;
  const auto take = [&ticks](std::size_t most) {
    return [&ticks, most](const v1::ReadSessionResponse& response) {
      ticks.push_back(response.batch().first_tick());
      return ticks.size() < most;
    };
  };
  EXPECT_TRUE(client_->ReadSession(request, take(100)));
  EXPECT_THAT(ticks, ElementsAre(10, 11, 12, 13, 14));
  ticks.clear();
  EXPECT_FALSE(client_->ReadSession(request, take(2)));
  EXPECT_THAT(ticks, ElementsAre(10, 11));
}

}  // namespace
}  // namespace mwidth::client
