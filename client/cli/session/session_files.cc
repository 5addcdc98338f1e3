#include "client/cli/session/session_files.h"

#include <algorithm>
#include <stdexcept>

namespace mwidth::cli::session {

namespace fs = std::filesystem;

std::vector<fs::path> AllFiles(const SessionOptions& options) {
  if (!fs::is_directory(options.folder)) {
    throw std::runtime_error("there is no folder " + options.folder +
                             ": --folder or MWIDTH_SESSIONS say where sessions are");
  }
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(options.folder)) {
    if (entry.is_regular_file() && entry.path().extension() == kSessionFileEnding) {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

fs::path FileOf(const SessionOptions& options, const std::string& name) {
  for (const fs::path& file : {fs::path(options.folder) / (name + kSessionFileEnding), fs::path(name)}) {
    if (fs::is_regular_file(file)) {
      return file;
    }
  }
  throw std::runtime_error("there is no session " + name + " in " + options.folder +
                           ": mwidth session list tells which there are, --folder says where to look");
}

}  // namespace mwidth::cli::session
