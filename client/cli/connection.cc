#include "client/cli/connection.h"

namespace mwidth::cli {

Connection Open(const CommandLine& line) {
  if (line.offline.empty()) {
    return {nullptr, client::Client::Connect(line.server)};
  }
  auto server = std::make_unique<offline::OfflineServer>(line.offline);
  const auto channel = server->Connect();
  return {std::move(server), client::Client(channel)};
}

}  // namespace mwidth::cli
