// What the stability model says of an axis's loop, or of any other.
#pragma once

#include "mwidth/v1/stability.grpc.pb.h"
#include "server/rpc/axis_registry.h"

namespace mwidth::rpc {

/// Reads no drive and changes nothing. Called from gRPC's threads.
class StabilityService final : public v1::StabilityService::Service {
 public:
  /// `axes` outlives the service.
  explicit StabilityService(const AxisRegistry& axes) : axes_(axes) {}

  grpc::Status GetMWidth(grpc::ServerContext* context, const v1::GetMWidthRequest* request,
                         v1::GetMWidthResponse* response) override;

 private:
  const AxisRegistry& axes_;
};

}  // namespace mwidth::rpc
