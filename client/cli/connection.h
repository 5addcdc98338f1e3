// Whom a command asks: a server, or its services in this process.
#pragma once

#include <memory>

#include "client/cli/command_line.h"
#include "client/cli/offline/offline_server.h"
#include "client/cpp/client.h"

namespace mwidth::cli {

struct Connection {
  /// Where there is one, it outlives the client.
  std::unique_ptr<offline::OfflineServer> server;
  client::Client client;
};

/// Connects to line.server or, where line.offline names a configuration, to nobody else. Throws client::Error
/// or server::ConfigError.
Connection Open(const CommandLine& line);

}  // namespace mwidth::cli
