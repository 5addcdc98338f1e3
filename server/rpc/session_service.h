// Recording by request: sessions begun, marked, ended, listed and read.
#pragma once

#include <mutex>
#include <optional>
#include <string>

#include "mwidth/v1/session.grpc.pb.h"
#include "server/gate/refusal.h"
#include "server/record/session/session_info.h"
#include "server/record/session/session_store.h"
#include "server/rpc/axis_registry.h"
#include "server/rpc/background.h"

namespace mwidth::rpc {

/// Most ReadSession calls at once: each keeps a thread and a file.
inline constexpr int kMaxSessionReaders = 8;

/// Where sessions are, and what every one of them says of the server. The store outlives the server.
struct Recording {
  record::SessionStore& store;
  record::SessionProvenance provenance;
};

/// Called from gRPC's threads. ReadSession blocks for as long as its client reads.
class SessionService final : public v1::SessionService::Service {
 public:
  /// `axes` outlives the service.
  SessionService(const AxisRegistry& axes, Recording recording);

  grpc::Status StartSession(grpc::ServerContext* context, const v1::StartSessionRequest* request,
                            v1::StartSessionResponse* response) override;
  grpc::Status EndSession(grpc::ServerContext* context, const v1::EndSessionRequest* request,
                          v1::EndSessionResponse* response) override;
  grpc::Status AddMarker(grpc::ServerContext* context, const v1::AddMarkerRequest* request,
                         v1::AddMarkerResponse* response) override;
  grpc::Status ListSessions(grpc::ServerContext* context, const v1::ListSessionsRequest* request,
                            v1::ListSessionsResponse* response) override;
  grpc::Status GetSession(grpc::ServerContext* context, const v1::GetSessionRequest* request,
                          v1::GetSessionResponse* response) override;
  grpc::Status ReadSession(grpc::ServerContext* context, const v1::ReadSessionRequest* request,
                           grpc::ServerWriter<v1::ReadSessionResponse>* writer) override;

 private:
  gate::Result<record::SessionInfo> Start(const Axis& axis, const v1::SessionLabels& sent);
  /// Precondition: the axis has a recorder.
  static gate::Result<record::SessionInfo> End(const Axis& axis, const std::string& session_id);
  /// The session of that id as it is recorded now, of any axis.
  std::optional<record::SessionInfo> ActiveOf(const std::string& session_id) const;
  /// What file and recorder say, with the file's size and the ticks that are absent.
  v1::Session Describe(const record::StoredSession& stored) const;

  const AxisRegistry& axes_;
  const Recording recording_;
  ComputationLimit readers_{kMaxSessionReaders};
  std::mutex ending_;
};

}  // namespace mwidth::rpc
