#include "server/rpc/status.h"

#include <exception>
#include <iostream>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "server/rpc/convert.h"

namespace mwidth::rpc {
namespace {

grpc::StatusCode Code(gate::RefusalCode code) {
  switch (code) {
    case gate::RefusalCode::kInvalidArgument:
      return grpc::StatusCode::INVALID_ARGUMENT;
    case gate::RefusalCode::kFailedPrecondition:
      return grpc::StatusCode::FAILED_PRECONDITION;
    case gate::RefusalCode::kAborted:
      return grpc::StatusCode::ABORTED;
    case gate::RefusalCode::kNotFound:
      return grpc::StatusCode::NOT_FOUND;
    case gate::RefusalCode::kPermissionDenied:
      return grpc::StatusCode::PERMISSION_DENIED;
    case gate::RefusalCode::kResourceExhausted:
      return grpc::StatusCode::RESOURCE_EXHAUSTED;
    case gate::RefusalCode::kUnavailable:
      return grpc::StatusCode::UNAVAILABLE;
    case gate::RefusalCode::kDataLoss:
      return grpc::StatusCode::DATA_LOSS;
  }
  return grpc::StatusCode::UNKNOWN;
}

}  // namespace

grpc::Status ToStatus(const gate::Refusal& refusal) {
  const grpc::StatusCode code = Code(refusal.code);
  google::rpc::ErrorInfo info;
  info.set_domain("mwidth");
  info.set_reason(refusal.reason);
  info.mutable_metadata()->insert(refusal.metadata.begin(), refusal.metadata.end());
  google::rpc::Status details;
  details.set_code(code);
  details.set_message(refusal.message);
  details.add_details()->PackFrom(info);
  if (refusal.stability) {
    v1::StabilityReport report;
    Convert(*refusal.stability, report);
    details.add_details()->PackFrom(report);
  }
  return {code, refusal.message, details.SerializeAsString()};
}

grpc::Status Guarded(const char* method, const std::function<grpc::Status()>& handler) noexcept {
  try {
    try {
      return handler();
    } catch (const std::exception& error) {
      std::cerr << "mwidthd: " << method << " failed: " << error.what() << std::endl;
      return {grpc::StatusCode::INTERNAL,
              std::string(method) + " failed inside the server; its log says why."};
    }
  } catch (...) {  // Not even the message could be made.
    return {grpc::StatusCode::INTERNAL, {}};
  }
}

}  // namespace mwidth::rpc
