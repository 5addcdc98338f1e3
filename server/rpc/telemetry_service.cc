#include "server/rpc/telemetry_service.h"

#include <chrono>
#include <utility>

#include "server/exchange/clock.h"
#include "server/gate/refusal.h"
#include "server/rpc/convert_record.h"
#include "server/rpc/event_source.h"
#include "server/rpc/sample_source.h"
#include "server/rpc/status.h"

namespace mwidth::rpc {

void TelemetryService::AddStreamsTo(StreamThread& thread) {
  thread.Add(
      MethodOf<v1::StreamSamplesRequest>("StreamSamples", *this, &TelemetryService::RequestStreamSamples,
                                         [this](const auto& request, auto wake, auto& refusal) {
                                           return OpenSamples(axes_, request, std::move(wake), refusal);
                                         }));
  thread.Add(MethodOf<v1::StreamEventsRequest>("StreamEvents", *this, &TelemetryService::RequestStreamEvents,
                                               [this](const auto& request, auto wake, auto& refusal) {
                                                 return OpenEvents(axes_, request, std::move(wake), refusal);
                                               }));
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
