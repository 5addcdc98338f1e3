// One unary call: a deadline, and an exception where it fails, or the refusal that it comes back with.
#pragma once

#include <grpcpp/client_context.h>

#include <chrono>
#include <utility>
#include <variant>

#include "client/cpp/failure.h"

namespace mwidth::client {

/// Lets the call of `context` fail with DEADLINE_EXCEEDED after `timeout`.
template <typename Duration>
void SetTimeout(grpc::ClientContext& context, Duration timeout) {
  // gRPC converts a system_clock deadline to its own monotonic clock when the call starts.
  context.set_deadline(std::chrono::system_clock::now() +
                       std::chrono::duration_cast<std::chrono::system_clock::duration>(timeout));
}

/// Calls `method` of `stub` and returns its response. Blocks; throws Error.
template <typename Stub, typename Request, typename Response, typename Duration>
Response Call(Stub& stub, grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Response*),
              const Request& request, Duration timeout) {
  grpc::ClientContext context;
  SetTimeout(context, timeout);
  Response response;
  if (const auto status = (stub.*method)(&context, request, &response); !status.ok()) {
    throw CallError(status);
  }
  return response;
}

/// The same for a method that may refuse a mass: the response, or the refusal in its place.
template <typename Stub, typename Request, typename Response, typename Duration>
std::variant<Response, Refusal> CallOrRefusal(Stub& stub,
                                              grpc::Status (Stub::*method)(grpc::ClientContext*,
                                                                           const Request&, Response*),
                                              const Request& request, Duration timeout) {
  grpc::ClientContext context;
  SetTimeout(context, timeout);
  Response response;
  const auto status = (stub.*method)(&context, request, &response);
  if (status.ok()) {
    return response;
  }
  if (auto refusal = DecodeRefusal(status)) {
    return *std::move(refusal);
  }
  throw CallError(status);
}

}  // namespace mwidth::client
