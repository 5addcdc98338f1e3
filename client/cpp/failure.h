// What the server says when it does not do what was asked.
#pragma once

#include <google/rpc/status.pb.h>
#include <grpcpp/support/status.h>
#include <mwidth/v1/stability.pb.h>

#include <optional>
#include <stdexcept>
#include <string>

namespace mwidth::client {

/// A mass that the server will not render, asked for or, with another filter, set already; and what it would
/// render. An answer, not an error: mass and filter stay.
struct Refusal {
  /// The server's own words.
  std::string sentence;
  /// A constant to compare with, such as "UNSTABLE_MASS".
  std::string reason;
  v1::StabilityReport stability;
  /// The whole answer as google.rpc.Status, for logs and JSON.
  google::rpc::Status status;
};

/// A call that failed: the server said no for another reason than the mass, or it could not be reached.
class Error : public std::runtime_error {
 public:
  /// Precondition: `status` is not ok.
  explicit Error(const grpc::Status& status);

  /// FAILED_PRECONDITION and ABORTED for lease and state, UNAVAILABLE where nobody answers, and so on.
  grpc::StatusCode code() const { return code_; }
  /// The reason of the google.rpc.ErrorInfo, such as "CONTROL_HELD"; empty where the server gave none.
  const std::string& reason() const { return reason_; }
  /// The whole answer as google.rpc.Status, for logs and JSON.
  const google::rpc::Status& status() const { return status_; }
  /// True when a server read the request and declined it; false when nobody answered or something broke.
  bool DeclinedByServer() const;

 private:
  grpc::StatusCode code_;
  std::string reason_;
  google::rpc::Status status_;
};

/// The Error of a call that ended with `status`, not ok: in the server's words or, where nobody could give
/// any, in gRPC's with what they mean. Any thread.
Error CallError(const grpc::Status& status);

/// The refusal of a mass that `status` carries: none unless its details hold a StabilityReport. Any thread.
std::optional<Refusal> DecodeRefusal(const grpc::Status& status);

}  // namespace mwidth::client
