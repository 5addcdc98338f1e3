// Who renders what: the gRPC end of the axis gates.
#pragma once

#include <string>

#include "mwidth/v1/rendering.grpc.pb.h"
#include "server/rpc/axis_registry.h"

namespace mwidth::rpc {

/// Translates requests for the gates, and answers and refusals back; decides nothing. Called from gRPC's
/// threads; a handler may block for as long as its gate waits for the loop.
class RenderingService final : public v1::RenderingService::Service {
 public:
  /// `axes` outlives the service.
  RenderingService(const AxisRegistry& axes, std::string server_version);

  grpc::Status GetState(grpc::ServerContext* context, const v1::GetStateRequest* request,
                        v1::GetStateResponse* response) override;
  grpc::Status AcquireControl(grpc::ServerContext* context, const v1::AcquireControlRequest* request,
                              v1::AcquireControlResponse* response) override;
  grpc::Status RenewControl(grpc::ServerContext* context, const v1::RenewControlRequest* request,
                            v1::RenewControlResponse* response) override;
  grpc::Status ReleaseControl(grpc::ServerContext* context, const v1::ReleaseControlRequest* request,
                              v1::ReleaseControlResponse* response) override;
  grpc::Status StartRendering(grpc::ServerContext* context, const v1::StartRenderingRequest* request,
                              v1::StartRenderingResponse* response) override;
  grpc::Status StopRendering(grpc::ServerContext* context, const v1::StopRenderingRequest* request,
                             v1::StopRenderingResponse* response) override;
  grpc::Status SetMass(grpc::ServerContext* context, const v1::SetMassRequest* request,
                       v1::SetMassResponse* response) override;
  grpc::Status SetFilter(grpc::ServerContext* context, const v1::SetFilterRequest* request,
                         v1::SetFilterResponse* response) override;
  grpc::Status EmergencyStop(grpc::ServerContext* context, const v1::EmergencyStopRequest* request,
                             v1::EmergencyStopResponse* response) override;
  grpc::Status ClearFault(grpc::ServerContext* context, const v1::ClearFaultRequest* request,
                          v1::ClearFaultResponse* response) override;

 private:
  gate::Result<std::vector<const Axis*>> FindOneOrAll(const std::string& name) const;

  const AxisRegistry& axes_;
  const std::string server_version_;
};

}  // namespace mwidth::rpc
