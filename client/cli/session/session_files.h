// Where sessions are.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "client/cli/command_line.h"
#include "server/record/session/session_store.h"

namespace mwidth::cli::session {

/// All sessions in the folder of `options`, the newest first. Throws std::runtime_error where there is no
/// such folder.
std::vector<record::StoredSession> AllSessions(const SessionOptions& options);

/// The file of the session that is called `name` in the folder of `options`, or that is the file `name`.
/// Throws std::runtime_error where there is neither.
std::filesystem::path FileOf(const SessionOptions& options, const std::string& name);

}  // namespace mwidth::cli::session
