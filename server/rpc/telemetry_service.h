// What a client may watch: every sample of the loop, and every event, as it happens.
#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>

#include "mwidth/v1/telemetry.grpc.pb.h"
#include "server/rpc/axis_registry.h"

namespace mwidth::rpc {

/// Checks requests and opens streams; see SampleStream. Methods are called by gRPC, from any of its threads.
///
/// StreamSamples exchanges raw bytes with gRPC, so that a serialized batch can be shared between streams. It
/// also refuses bytes that are no request with INTERNAL, as gRPC does elsewhere; its callback API would say
/// UNIMPLEMENTED.
class TelemetryService final
    : public v1::TelemetryService::WithRawCallbackMethod_StreamSamples<
          v1::TelemetryService::WithCallbackMethod_StreamEvents<v1::TelemetryService::Service>> {
 public:
  /// `axes` outlives the server.
  explicit TelemetryService(const AxisRegistry& axes);

  grpc::ServerWriteReactor<grpc::ByteBuffer>* StreamSamples(grpc::CallbackServerContext* context,
                                                            const grpc::ByteBuffer* request) override;
  grpc::ServerWriteReactor<v1::StreamEventsResponse>* StreamEvents(
      grpc::CallbackServerContext* context, const v1::StreamEventsRequest* request) override;
  grpc::Status SyncClock(grpc::ServerContext* context, const v1::SyncClockRequest* request,
                         v1::SyncClockResponse* response) override;

 private:
  const AxisRegistry& axes_;
};

}  // namespace mwidth::rpc
