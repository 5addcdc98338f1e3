// What a client may watch: every sample of the loop, and every event, as it happens.
#pragma once

#include <grpcpp/server_context.h>

#include "mwidth/v1/telemetry.grpc.pb.h"
#include "server/rpc/axis_registry.h"
#include "server/rpc/stream_thread.h"

namespace mwidth::rpc {

/// SyncClock is called by gRPC, from any of its threads; the streams are served by a StreamThread.
class TelemetryService final
    : public v1::TelemetryService::WithRawMethod_StreamSamples<
          v1::TelemetryService::WithRawMethod_StreamEvents<v1::TelemetryService::Service>> {
 public:
  /// `axes` outlives the server.
  explicit TelemetryService(const AxisRegistry& axes) : axes_(axes) {}

  /// Has `thread` serve the streams, before the server starts. This outlives the thread.
  void AddStreamsTo(StreamThread& thread);

  grpc::Status SyncClock(grpc::ServerContext* context, const v1::SyncClockRequest* request,
                         v1::SyncClockResponse* response) override;

 private:
  const AxisRegistry& axes_;
};

}  // namespace mwidth::rpc
