// What StreamSamples sends.
#pragma once

#include <functional>
#include <memory>

#include <grpcpp/support/status.h>

#include "mwidth/v1/telemetry.pb.h"
#include "server/rpc/axis_registry.h"
#include "server/rpc/stream_source.h"

namespace mwidth::rpc {

/// An axis's samples from the next tick on, batch after batch. A client that does not read fills its queue in
/// the broadcast, which then drops. nullptr and why not where the request is refused; `axes` outlives it.
std::unique_ptr<StreamSource> OpenSamples(const AxisRegistry& axes, const v1::StreamSamplesRequest& request,
                                          std::function<void()> wake, grpc::Status& refusal);

}  // namespace mwidth::rpc
