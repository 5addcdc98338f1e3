#include <algorithm>
#include <iostream>

#include "client/cli/commands.h"
#include "client/cli/session/session_files.h"
#include "client/cli/session/verbs.h"
#include "server/record/export/session_json.h"
#include "server/record/session/session_store.h"

namespace mwidth::cli::session {
namespace {

namespace fs = std::filesystem;

struct Outcome {
  bool recovered = false;
  /// What was done, or why nothing was.
  std::string message;
  int code = kDone;
};

Outcome RecoverOne(const fs::path& file) {
  try {
    if (record::SessionStore::Recover(file)) {
      const auto info = record::SessionReader(file).info();
      return {.recovered = true,
              .message = "recovered, " + std::to_string(info.sample_count) + " samples",
              .code = kDone};
    }
    if (record::SessionLock::Held(file)) {
      return {.recovered = false, .message = "is being recorded: left as it is", .code = kRefused};
    }
    return {.recovered = false, .message = "is closed already", .code = kDone};
  } catch (const std::runtime_error& error) {
    // The others may still be recovered.
    return {.recovered = false, .message = error.what(), .code = kFailed};
  }
}

std::vector<fs::path> Files(const SessionOptions& options) {
  std::vector<fs::path> files;
  if (!options.sessions.empty()) {
    for (const std::string& name : options.sessions) {
      files.push_back(FileOf(options, name));
    }
    return files;
  }
  for (const auto& stored : AllSessions(options)) {
    if (stored.info && stored.info->state == record::SessionState::kOpen && !stored.recording) {
      files.push_back(stored.file);
    }
  }
  return files;
}

}  // namespace

int Recover(const CommandLine& line) {
  int code = kDone;
  auto json = nlohmann::ordered_json::array();
  const auto files = Files(line.session);
  for (const fs::path& file : files) {
    const Outcome outcome = RecoverOne(file);
    code = std::max(code, outcome.code);
    json.push_back(
        {{"session", file.stem().string()}, {"recovered", outcome.recovered}, {"message", outcome.message}});
    if (!line.json) {
      (outcome.code == kDone ? std::cout : std::cerr)
          << file.stem().string() << ": " << outcome.message << "\n";
    }
  }
  if (line.json) {
    std::cout << record::Indented(json);
  } else if (files.empty()) {
    std::cout << "No session needs it.\n";
  }
  return code;
}

}  // namespace mwidth::cli::session
