// What StreamEvents sends.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include <grpcpp/support/status.h>

#include "mwidth/v1/telemetry.pb.h"
#include "server/rpc/axis_registry.h"
#include "server/rpc/stream_source.h"

namespace mwidth::rpc {

/// Most StreamEvents calls on one axis.
inline constexpr std::size_t kMaxEventStreams = 64;

/// An axis's events from now on, or behind the number that is asked for. nullptr and why not where the
/// request is refused; `axes` outlives it.
std::unique_ptr<StreamSource> OpenEvents(const AxisRegistry& axes, const v1::StreamEventsRequest& request,
                                         std::function<void()> wake, grpc::Status& refusal);

}  // namespace mwidth::rpc
