// What the stability model says of an axis's loop, or of any other.
#pragma once

#include <memory>

#include "mwidth/v1/stability.grpc.pb.h"
#include "server/gate/refusal.h"
#include "server/gate/requirements.h"
#include "server/gate/stability_gate.h"
#include "server/model/certificate_cache.h"
#include "server/model/loop_parameters.h"
#include "server/rpc/axis_registry.h"
#include "server/rpc/background.h"

namespace mwidth::rpc {

/// Reads no drive and changes nothing. Called from gRPC's threads. What takes longer than some milliseconds
/// runs on threads of its own at low priority, and only kMostComputations at once.
class StabilityService final : public v1::StabilityService::Service {
 public:
  static constexpr int kMostComputations = 4;

  /// `axes` outlives the service.
  explicit StabilityService(const AxisRegistry& axes) : axes_(axes) {}

  grpc::Status GetMWidth(grpc::ServerContext* context, const v1::GetMWidthRequest* request,
                         v1::GetMWidthResponse* response) override;
  grpc::Status SweepMWidth(grpc::ServerContext* context, const v1::SweepMWidthRequest* request,
                           grpc::ServerWriter<v1::SweepMWidthResponse>* writer) override;
  grpc::Status GetFrequencyResponse(grpc::ServerContext* context,
                                    const v1::GetFrequencyResponseRequest* request,
                                    v1::GetFrequencyResponseResponse* response) override;
  grpc::Status GetAccuracy(grpc::ServerContext* context, const v1::GetAccuracyRequest* request,
                           v1::GetAccuracyResponse* response) override;

 private:
  gate::Result<gate::StabilityGate> Judge(const model::LoopParameters& loop,
                                          const gate::Requirements& requirements);

  const AxisRegistry& axes_;
  const std::shared_ptr<model::CertificateCache> certificates_ = std::make_shared<model::CertificateCache>();
  ComputationLimit computations_{kMostComputations};
};

}  // namespace mwidth::rpc
