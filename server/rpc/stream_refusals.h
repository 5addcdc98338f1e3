// Why a stream is not opened, or ends.
#pragma once

#include <cstddef>
#include <string>

#include <grpcpp/support/status.h>

namespace mwidth::rpc {

/// RESOURCE_EXHAUSTED, TOO_MANY_STREAMS.
grpc::Status TooManyStreams(const std::string& axis, std::size_t max_streams);
/// UNAVAILABLE, SHUTTING_DOWN.
grpc::Status ShuttingDown();

}  // namespace mwidth::rpc
