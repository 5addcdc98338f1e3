#include "client/cli/session/session_files.h"

#include <stdexcept>

namespace mwidth::cli::session {

namespace fs = std::filesystem;

namespace {

// Sessions are only looked at: how much room new ones need does not matter.
constexpr uint64_t kNoSpaceNeeded = 0;

}  // namespace

std::vector<record::StoredSession> AllSessions(const SessionOptions& options) {
  if (!fs::is_directory(options.folder)) {
    throw std::runtime_error("there is no folder " + options.folder +
                             ": --folder or MWIDTH_SESSIONS say where sessions are");
  }
  return record::SessionStore(options.folder, kNoSpaceNeeded).List();
}

fs::path FileOf(const SessionOptions& options, const std::string& name) {
  if (const auto file = record::SessionStore(options.folder, kNoSpaceNeeded).PathOf(name)) {
    return *file;
  }
  if (fs::is_regular_file(name)) {
    return name;
  }
  throw std::runtime_error("there is no session " + name + " in " + options.folder +
                           ": mwidth session list tells which there are, --folder says where to look");
}

}  // namespace mwidth::cli::session
