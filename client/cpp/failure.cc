#include "client/cpp/failure.h"

#include <google/rpc/error_details.pb.h>

namespace mwidth::client {
namespace {

// The trailer "grpc-status-details-bin" holds a google.rpc.Status. A proxy or gRPC itself may answer without
// one, or with bytes that are none; code and message then come from the plain status.
google::rpc::Status Decode(const grpc::Status& status) {
  google::rpc::Status decoded;
  if (status.error_details().empty() || !decoded.ParseFromString(status.error_details())) {
    decoded.Clear();
  }
  decoded.set_code(status.error_code());
  decoded.set_message(status.error_message());
  return decoded;
}

template <typename Message>
std::optional<Message> Detail(const google::rpc::Status& status) {
  Message message;
  for (const auto& detail : status.details()) {
    if (detail.Is<Message>() && detail.UnpackTo(&message)) {
      return message;
    }
  }
  return std::nullopt;
}

std::string Reason(const google::rpc::Status& status) {
  const auto info = Detail<google::rpc::ErrorInfo>(status);
  return info ? info->reason() : std::string();
}

}  // namespace

Error::Error(const grpc::Status& status)
    : std::runtime_error(status.error_message()),
      code_(status.error_code()),
      reason_(Reason(Decode(status))),
      status_(Decode(status)) {}

bool Error::DeclinedByServer() const {
  switch (code_) {
    case grpc::StatusCode::FAILED_PRECONDITION:
    case grpc::StatusCode::INVALID_ARGUMENT:
    case grpc::StatusCode::NOT_FOUND:
    case grpc::StatusCode::ABORTED:
    case grpc::StatusCode::PERMISSION_DENIED:
    case grpc::StatusCode::UNAUTHENTICATED:
    case grpc::StatusCode::RESOURCE_EXHAUSTED:
      return true;
    default:
      return false;
  }
}

Error CallError(const grpc::Status& status) {
  if (status.error_details().empty() && status.error_code() == grpc::StatusCode::UNAVAILABLE) {
    return Error({status.error_code(), "the server cannot be reached: " + status.error_message()});
  }
  if (status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED) {
    return Error({status.error_code(), "the server did not answer in time"});
  }
  return Error(status);
}

std::optional<Refusal> DecodeRefusal(const grpc::Status& status) {
  auto decoded = Decode(status);
  auto report = Detail<v1::StabilityReport>(decoded);
  if (status.ok() || !report) {
    return std::nullopt;
  }
  std::string reason = Reason(decoded);
  return Refusal{.sentence = status.error_message(),
                 .reason = std::move(reason),
                 .stability = std::move(*report),
                 .status = std::move(decoded)};
}

}  // namespace mwidth::client
