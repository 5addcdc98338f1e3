// The server's own services for a configuration, inside this process: the same answers without a server.
#pragma once

#include <grpcpp/channel.h>

#include <memory>
#include <string>

namespace mwidth::offline {

/// Answers for the axes of a configuration as mwidthd does, by the same code: what it computes agrees to the
/// last bit. Opens no port and no drive; no loop runs, so that nothing can be rendered. One thread.
class OfflineServer {
 public:
  /// `name_or_file` as for mwidthd --config: a TOML file or a shipped configuration. Throws
  /// server::ConfigError, a std::runtime_error, where it cannot be used.
  explicit OfflineServer(const std::string& name_or_file);
  OfflineServer(const OfflineServer&) = delete;
  OfflineServer& operator=(const OfflineServer&) = delete;
  ~OfflineServer();

  /// Not to be used once the server is gone.
  std::shared_ptr<grpc::Channel> Connect();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace mwidth::offline
