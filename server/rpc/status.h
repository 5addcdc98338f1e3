// How a refusal of the gate reaches a gRPC client.
#pragma once

#include <grpcpp/support/status.h>

#include "server/gate/refusal.h"

namespace mwidth::rpc {

/// The status of a refusal. Its details are a google.rpc.Status with an ErrorInfo (domain "mwidth", the
/// refusal's reason and metadata) and, where the refusal has one, a StabilityReport.
grpc::Status ToStatus(const gate::Refusal& refusal);

}  // namespace mwidth::rpc
