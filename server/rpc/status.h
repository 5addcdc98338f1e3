// How a refusal of the gate, or a failure of the server itself, reaches a gRPC client.
#pragma once

#include <grpcpp/support/status.h>

#include <functional>

#include "server/gate/refusal.h"

namespace mwidth::rpc {

/// The status of a refusal. Its details are a google.rpc.Status with an ErrorInfo (domain "mwidth", the
/// refusal's reason and metadata) and, where the refusal has one, a StabilityReport.
grpc::Status ToStatus(const gate::Refusal& refusal);

/// What `handler` returns, or INTERNAL where it throws: no exception crosses into gRPC, which would answer
/// UNKNOWN. What was thrown goes to the log only.
grpc::Status Guarded(const char* method, const std::function<grpc::Status()>& handler) noexcept;

}  // namespace mwidth::rpc
