#include "server/rpc/server.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server_builder.h>

#include <cstdint>
#include <limits>
#include <stdexcept>

namespace mwidth::rpc {
namespace {

// A client whose host vanished is noticed after this long without an answer, so that its streams end.
constexpr int kKeepaliveMs = 10'000;
constexpr int kKeepaliveTimeoutMs = 5'000;
constexpr int kMaxCallsPerConnection = 100;

// Splits "HOST:PORT" and returns HOST, in brackets where it has colons itself. gRPC would take a service name
// for a port, and wrap a number that is too large.
std::string HostOf(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  std::string host = address.substr(0, colon == std::string::npos ? 0 : colon);
  const std::string port = colon == std::string::npos ? "" : address.substr(colon + 1);
  const bool digits =
      !port.empty() && port.size() <= 5 && port.find_first_not_of("0123456789") == std::string::npos;
  const bool bracketed = !host.empty() && host.front() == '[' && host.back() == ']';
  if (host.empty() || (host.find(':') != std::string::npos && !bracketed) || !digits ||
      std::stoi(port) > std::numeric_limits<uint16_t>::max()) {
    throw std::invalid_argument(
        "cannot listen on '" + address +
        "': give HOST:PORT, such as 127.0.0.1:50051 or [::1]:0, with a port of 0 (any free "
        "one) to 65535");
  }
  return host;
}

}  // namespace

Server::Server(const AxisRegistry& axes, const std::string& address, const std::string& server_version,
               std::optional<Recording> recording)
    : rendering_(axes, server_version), stability_(axes), telemetry_(axes) {
  const std::string host = HostOf(address);
  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  int port = 0;
  builder.AddListeningPort(address, grpc::InsecureServerCredentials(), &port);
  // With SO_REUSEPORT two servers would share the port, and a client would command now one, now the other.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveMs);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kKeepaliveTimeoutMs);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, kMaxCallsPerConnection);
  builder.SetMaxReceiveMessageSize(kMaxRequestBytes);
  builder.RegisterService(&rendering_);
  builder.RegisterService(&stability_);
  telemetry_.AddTo(builder);
  if (recording) {
    builder.RegisterService(&sessions_.emplace(axes, *std::move(recording)));
  }
  server_ = builder.BuildAndStart();
  if (!server_ || port == 0) {
    throw std::runtime_error(
        "cannot listen on " + address +
        ": is it an address of this host, and does no other server (another mwidthd, say) "
        "listen there already?");
  }
  telemetry_.Start();
  address_ = host + ":" + std::to_string(port);
  for (const char* service :
       {"mwidth.v1.RenderingService", "mwidth.v1.StabilityService", "mwidth.v1.TelemetryService"}) {
    server_->GetHealthCheckService()->SetServingStatus(service, true);
  }
  if (sessions_) {
    server_->GetHealthCheckService()->SetServingStatus("mwidth.v1.SessionService", true);
  }
}

Server::~Server() { Shutdown(std::chrono::milliseconds(0)); }

void Server::Shutdown(std::chrono::milliseconds patience) {
  server_->GetHealthCheckService()->SetServingStatus(false);
  server_->Shutdown(std::chrono::system_clock::now() + patience);
  telemetry_.Stop();
}

}  // namespace mwidth::rpc
