// Where sessions are.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "client/cli/command_line.h"

namespace mwidth::cli::session {

/// Of the names of their files.
inline constexpr const char* kSessionFileEnding = ".sqlite";

/// Every file in the folder of `options` that is called as sessions are. Throws std::runtime_error where
/// there is no such folder.
std::vector<std::filesystem::path> AllFiles(const SessionOptions& options);

/// The file of the session that is called `name` in the folder of `options`, or that is the file `name`.
/// Throws std::runtime_error where there is neither.
std::filesystem::path FileOf(const SessionOptions& options, const std::string& name);

}  // namespace mwidth::cli::session
