// What a client may watch: every sample of the loop, and every event, as it happens.
#pragma once

#include <grpcpp/server_builder.h>
#include <grpcpp/server_context.h>

#include "mwidth/v1/telemetry.grpc.pb.h"
#include "server/rpc/axis_registry.h"
#include "server/rpc/sample_streams.h"

namespace mwidth::rpc {

/// Checks requests and opens streams. Methods are called by gRPC, from any of its threads, but for
/// StreamSamples, which SampleStreams serves: its messages are raw bytes, so that a serialized batch can be
/// shared between streams.
class TelemetryService final
    : public v1::TelemetryService::WithRawMethod_StreamSamples<
          v1::TelemetryService::WithCallbackMethod_StreamEvents<v1::TelemetryService::Service>> {
 public:
  /// `axes` outlives the server.
  explicit TelemetryService(const AxisRegistry& axes);

  /// Registers the service, once, with what it needs.
  void AddTo(grpc::ServerBuilder& builder);
  /// Begins to serve StreamSamples: when the server has started.
  void Start() { streams_.Start(); }
  /// Ends what is left of its streams: between the shutdown of the server and its destruction. Does no harm
  /// twice.
  void Stop() { streams_.Stop(); }

  grpc::ServerWriteReactor<v1::StreamEventsResponse>* StreamEvents(
      grpc::CallbackServerContext* context, const v1::StreamEventsRequest* request) override;
  grpc::Status SyncClock(grpc::ServerContext* context, const v1::SyncClockRequest* request,
                         v1::SyncClockResponse* response) override;

 private:
  const AxisRegistry& axes_;
  SampleStreams streams_;
};

}  // namespace mwidth::rpc
