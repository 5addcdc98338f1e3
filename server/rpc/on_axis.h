// The shape of most handlers: find the axis, command its gate, fill the response or refuse.
#pragma once

#include <string>

#include "server/rpc/axis_registry.h"
#include "server/rpc/status.h"

namespace mwidth::rpc {

/// Runs `command(axis)`, which returns a gate::Result, on the axis named `name`; then either `fill(value)` or
/// the refusal's status. INTERNAL where anything throws.
template <typename Command, typename Fill>
grpc::Status OnAxis(const char* method, const AxisRegistry& axes, const std::string& name,
                    const Command& command, const Fill& fill) {
  return Guarded(method, [&] {
    const gate::Result<const Axis*> axis = axes.Find(name);
    if (!axis.ok()) {
      return ToStatus(axis.refusal());
    }
    const auto result = command(**axis);
    if (!result.ok()) {
      return ToStatus(result.refusal());
    }
    fill(*result);
    return grpc::Status::OK;
  });
}

}  // namespace mwidth::rpc
