#include "server/config_sessions.h"

#include <optional>

namespace mwidth::server {
namespace {

constexpr const char* kDefaultFolder = "mwidth-sessions";
constexpr int kDefaultMinFreeMb = 200;
constexpr int kDefaultQueueSamples = 100'000;
constexpr double kMostMb = 1e6;
constexpr double kMostSamples = 1e7;

}  // namespace

SessionsConfig ReadSessions(ConfigTable& server) {
  SessionsConfig read{
      .folder = kDefaultFolder, .min_free_mb = kDefaultMinFreeMb, .queue_samples = kDefaultQueueSamples};
  std::optional<ConfigTable> table = server.OptionalTable("sessions");
  if (table) {
    read.folder = table->StringOr("folder", kDefaultFolder);
    if (read.folder.empty()) {
      table->Refuse("folder", "is empty; name a folder, or leave it out");
    }
    read.min_free_mb = table->IntegerOr("min_free_mb", {1, kMostMb}, kDefaultMinFreeMb);
    read.queue_samples = table->IntegerOr("queue_samples", {1000, kMostSamples}, kDefaultQueueSamples);
    table->Finish();
  }
  return read;
}

}  // namespace mwidth::server
