#include "server/rpc/stream_refusals.h"

#include "server/gate/refusal.h"
#include "server/rpc/status.h"

namespace mwidth::rpc {

grpc::Status TooManyStreams(const std::string& axis, std::size_t max_streams) {
  const std::string limit = std::to_string(max_streams);
  return ToStatus(
      {.code = gate::RefusalCode::kResourceExhausted,
       .reason = gate::kTooManyStreams,
       .message = "Axis '" + axis + "' streams to " + limit +
                  " clients already, its limit: end one of these streams, or raise the limit in the "
                  "server's configuration.",
       .metadata = {{"axis", axis}, {"max_streams", limit}}});
}

grpc::Status ShuttingDown() {
  return ToStatus({.code = gate::RefusalCode::kUnavailable,
                   .reason = gate::kShuttingDown,
                   .message = "The server is shutting down: connect again when it is back."});
}

}  // namespace mwidth::rpc
