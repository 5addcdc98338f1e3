// `mwidth session report`.
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <stdexcept>

#include "client/cli/commands.h"
#include "client/cli/session/page.h"
#include "client/cli/session/session_files.h"
#include "client/cli/session/verbs.h"
#include "server/record/session/session_reader.h"

namespace mwidth::cli::session {
namespace {

Analysis Read(const std::filesystem::path& file) {
  record::SessionReader reader(file);
  Analysis analysis;
  analysis.info = reader.info();
  analysis.events = reader.Events();
  analysis.markers = reader.Markers();
  analysis.wall_clock_steps = reader.WallClockSteps();
  ReadSamples([&reader](std::vector<exchange::Sample>& samples) { return reader.Next(samples); }, analysis);
  // Those that damaged blocks leave are known only now.
  analysis.damaged = reader.damaged();
  analysis.gaps = reader.Gaps();
  return analysis;
}

// Whole, or not at all: a page that ends in its middle would look like a session that does.
void Write(const Analysis& analysis, const std::filesystem::path& file) {
  std::filesystem::path partial = file;
  partial += ".partial";
  std::ofstream out(partial, std::ios::binary);
  WritePage(analysis, out);
  out.close();
  if (!out) {
    const std::string reason = std::strerror(errno);
    std::error_code ignored;
    std::filesystem::remove(partial, ignored);
    throw std::runtime_error("cannot write " + file.string() + ": " + reason);
  }
  std::filesystem::rename(partial, file);
}

}  // namespace

int Report(const CommandLine& line) {
  const std::filesystem::path session = FileOf(line.session, line.session.sessions.front());
  const Analysis analysis = Read(session);
  const std::filesystem::path page =
      line.session.to.empty() ? session.stem().string() + ".html" : line.session.to;
  Write(analysis, page);
  std::cout << page.string() << "\n";
  if (!analysis.damaged.empty()) {
    std::cerr << "mwidth: " << analysis.damaged.size()
              << " blocks of the file cannot be trusted, and are not in the report\n";
    return kRefused;
  }
  return kDone;
}

}  // namespace mwidth::cli::session
