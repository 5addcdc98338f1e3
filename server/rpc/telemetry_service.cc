#include "server/rpc/telemetry_service.h"

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include <grpcpp/support/server_callback.h>

#include "server/exchange/clock.h"
#include "server/gate/refusal.h"
#include "server/record/event_log.h"
#include "server/rpc/convert_record.h"
#include "server/rpc/event_stream.h"
#include "server/rpc/status.h"

namespace mwidth::rpc {

TelemetryService::TelemetryService(const AxisRegistry& axes)
    : axes_(axes),
      streams_(axes, [this](grpc::ServerContext& context, grpc::ByteBuffer& request,
                            grpc::ServerAsyncWriter<grpc::ByteBuffer>& writer,
                            grpc::ServerCompletionQueue& queue, void* tag) {
        RequestStreamSamples(&context, &request, &writer, &queue, &queue, tag);
      }) {}

void TelemetryService::AddTo(grpc::ServerBuilder& builder) {
  streams_.AddTo(builder);
  builder.RegisterService(this);
}

grpc::ServerWriteReactor<v1::StreamEventsResponse>* TelemetryService::StreamEvents(
    grpc::CallbackServerContext* /*context*/, const v1::StreamEventsRequest* request) {
  EventStream* stream = nullptr;
  const grpc::Status status = Guarded("StreamEvents", [&]() -> grpc::Status {
    const gate::Result<const Axis*> axis = axes_.Find(request->axis());
    if (!axis.ok()) {
      return ToStatus(axis.refusal());
    }
    record::EventLog& events = (*axis)->events;
    const uint64_t after = request->has_after_number() ? request->after_number() : events.newest();
    stream = EventStream::Open((*axis)->name, events, after);
    return grpc::Status::OK;
  });
  if (stream != nullptr) {
    return stream;
  }
  return new RefusedStream<v1::StreamEventsResponse>(status);
}

grpc::Status TelemetryService::SyncClock(grpc::ServerContext*, const v1::SyncClockRequest* request,
                                         v1::SyncClockResponse* response) {
  return Guarded("SyncClock", [&] {
    const gate::Result<const Axis*> axis = axes_.Find(request->axis());
    if (!axis.ok()) {
      return ToStatus(axis.refusal());
    }
    response->set_server_receive_ns((*axis)->clock.NowNs());
    response->set_client_send_ns(request->client_send_ns());
    const auto wall = std::chrono::system_clock::now().time_since_epoch();
    *response->mutable_wall_time() =
        WallTime(std::chrono::duration_cast<std::chrono::nanoseconds>(wall).count());
    response->set_server_send_ns((*axis)->clock.NowNs());
    return grpc::Status::OK;
  });
}

}  // namespace mwidth::rpc
