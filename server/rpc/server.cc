#include "server/rpc/server.h"

#include <absl/synchronization/mutex.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server_builder.h>

#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

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

std::vector<std::string> ServicesOf(bool recording) {
  std::vector<std::string> services = {"mwidth.v1.RenderingService", "mwidth.v1.StabilityService",
                                       "mwidth.v1.TelemetryService"};
  if (recording) {
    services.emplace_back("mwidth.v1.SessionService");
  }
  return services;
}

}  // namespace

Server::Server(const AxisRegistry& axes, const std::string& address, const std::string& server_version,
               std::optional<Recording> recording)
    : rendering_(axes, server_version),
      stability_(axes),
      telemetry_(axes),
      health_(ServicesOf(recording.has_value())) {
  // Debian builds abseil, which gRPC locks with, to look for cycles of locks at each of them: streams pay for
  // it with every message.
  absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore);
  const std::string host = HostOf(address);
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
  builder.RegisterService(&telemetry_);
  builder.RegisterService(&health_);
  if (recording) {
    builder.RegisterService(&sessions_.emplace(axes, *std::move(recording)));
  }
  telemetry_.AddStreamsTo(streams_);
  health_.AddStreamsTo(streams_);
  streams_.AddTo(builder);
  server_ = builder.BuildAndStart();
  if (!server_ || port == 0) {
    throw std::runtime_error(
        "cannot listen on " + address +
        ": is it an address of this host, and does no other server (another mwidthd, say) "
        "listen there already?");
  }
  streams_.Start();
  address_ = host + ":" + std::to_string(port);
}

Server::~Server() { Shutdown(std::chrono::milliseconds(0)); }

void Server::Shutdown(std::chrono::milliseconds patience) {
  health_.StopServing();
  server_->Shutdown(std::chrono::system_clock::now() + patience);
  streams_.Stop();
}

}  // namespace mwidth::rpc
