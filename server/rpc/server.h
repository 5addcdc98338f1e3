// The gRPC server: its address, its services, its end.
#pragma once

#include <grpcpp/server.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "server/rpc/axis_registry.h"
#include "server/rpc/health_service.h"
#include "server/rpc/rendering_service.h"
#include "server/rpc/session_service.h"
#include "server/rpc/stability_service.h"
#include "server/rpc/stream_thread.h"
#include "server/rpc/telemetry_service.h"

namespace mwidth::rpc {

/// Largest request; a larger one is refused with RESOURCE_EXHAUSTED before it is decoded.
inline constexpr int kMaxRequestBytes = 64 * 1024;

/// Serves the API, the standard health service and server reflection, from construction to Shutdown.
class Server {
 public:
  /// Listens on `address` ("HOST:PORT"; port 0: any free one), which no other process may share. `axes`
  /// outlives the server. Throws std::invalid_argument for an address that is malformed and
  /// std::runtime_error for one that cannot be had, with what to do.
  /// Without `recording` there is no SessionService.
  Server(const AxisRegistry& axes, const std::string& address, const std::string& server_version,
         std::optional<Recording> recording = std::nullopt);
  /// Shuts down at once unless Shutdown was called.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// "HOST:PORT" with the port that was bound.
  const std::string& address() const { return address_; }

  /// Reports NOT_SERVING, accepts nothing more, lets running calls finish for `patience`, then cancels them.
  /// Any thread but a handler's; the second call does nothing. An axis goes on as its lease says: stop its
  /// loop first.
  void Shutdown(std::chrono::milliseconds patience);

 private:
  RenderingService rendering_;
  StabilityService stability_;
  TelemetryService telemetry_;
  std::optional<SessionService> sessions_;
  HealthService health_;
  StreamThread streams_;
  std::string address_;
  std::unique_ptr<grpc::Server> server_;
};

}  // namespace mwidth::rpc
