// Client: clocks, events and recorded sessions.
#include <algorithm>
#include <limits>

#include "client/cpp/call.h"
#include "client/cpp/client.h"
#include "client/cpp/read_stream.h"

namespace mwidth::client {
namespace {

using Sessions = v1::SessionService::StubInterface;

int64_t NowNs() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace

void Client::WatchEvents(const v1::StreamEventsRequest& request,
                         const std::function<bool(const v1::StreamEventsResponse&)>& take) const {
  grpc::ClientContext context;
  const auto reader = telemetry_->StreamEvents(&context, request);
  ReadStream(context, *reader, take);
}

// With the client's times t0, t3 and the server's t1, t2, and however the way's time splits between there and
// back, the offset lies between t2 - t3 and t1 - t0; the exchange with the shortest way bounds it best.
ClockOffset Client::SyncClock(const std::string& axis, int count) const {
  int64_t best_least = std::numeric_limits<int64_t>::min() / 4;
  int64_t best_greatest = std::numeric_limits<int64_t>::max() / 4;
  for (int i = 0; i < std::max(1, count); ++i) {
    v1::SyncClockRequest request;
    request.set_axis(axis);
    request.set_client_send_ns(NowNs());
    const auto answer =
        Call(*telemetry_, &v1::TelemetryService::StubInterface::SyncClock, request, call_timeout_);
    const int64_t least = answer.server_send_ns() - NowNs();
    const int64_t greatest = answer.server_receive_ns() - answer.client_send_ns();
    if (greatest - least < best_greatest - best_least) {
      best_least = least;
      best_greatest = greatest;
    }
  }
  const int64_t width = best_greatest - best_least;
  return {.offset = std::chrono::nanoseconds(best_least + width / 2),
          .error = std::chrono::nanoseconds((width + 1) / 2)};
}

v1::Session Client::StartSession(const v1::SessionLabels& labels, const std::string& axis) const {
  v1::StartSessionRequest request;
  request.set_axis(axis);
  *request.mutable_labels() = labels;
  return Call(*sessions_, &Sessions::StartSession, request, call_timeout_).session();
}

v1::Session Client::EndSession(const std::string& session_id) const {
  v1::EndSessionRequest request;
  request.set_session_id(session_id);
  return Call(*sessions_, &Sessions::EndSession, request, call_timeout_).session();
}

v1::Marker Client::AddMarker(const v1::AddMarkerRequest& request) const {
  return Call(*sessions_, &Sessions::AddMarker, request, call_timeout_).marker();
}

v1::ListSessionsResponse Client::ListSessions(const v1::ListSessionsRequest& request) const {
  return Call(*sessions_, &Sessions::ListSessions, request, call_timeout_);
}

v1::GetSessionResponse Client::GetSession(const std::string& session_id) const {
  v1::GetSessionRequest request;
  request.set_session_id(session_id);
  return Call(*sessions_, &Sessions::GetSession, request, call_timeout_);
}

bool Client::ReadSession(const v1::ReadSessionRequest& request,
                         const std::function<bool(const v1::ReadSessionResponse&)>& take) const {
  grpc::ClientContext context;
  const auto reader = sessions_->ReadSession(&context, request);
  return ReadStream(context, *reader, take);
}

}  // namespace mwidth::client
