// One streaming call, read to its end or until there is enough.
#pragma once

#include <grpcpp/client_context.h>
#include <grpcpp/support/sync_stream.h>

#include <functional>
#include <memory>

#include "client/cpp/failure.h"

namespace mwidth::client {

/// Hands response after response of `reader` to `take`, until that returns false. Returns whether all were
/// taken. Throws Error where the call failed.
template <typename Response>
bool ReadStream(grpc::ClientContext& context, grpc::ClientReaderInterface<Response>& reader,
                const std::function<bool(const Response&)>& take) {
  bool wanted = true;
  Response response;
  while (wanted && reader.Read(&response)) {
    wanted = take(response);
  }
  if (!wanted) {
    context.TryCancel();
  }
  // Finish answers only once everything is read.
  while (reader.Read(&response)) {
  }
  const auto status = reader.Finish();
  if (wanted && !status.ok()) {
    throw CallError(status);
  }
  return wanted;
}

}  // namespace mwidth::client
