// Writes a session of reaches as a server would, and beside it as CSV by a way of its own: what a test may
// compute from, without anything of what it tests.
//
//   write_reach_session FOLDER [--unmarked] [--hostile] [--lossy] [--altered] [--open]
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "server/record/session/session_file.h"
#include "tests/client/cli/session/reach_session.h"

namespace mwidth::cli::session {
namespace {

void WriteCsv(const RecordedSession& session, const std::filesystem::path& file) {
  std::ofstream out(file);
  out << "tick,position,force,mass\n";
  for (const exchange::Sample& sample : session.samples) {
    char row[128];
    std::snprintf(row, sizeof(row), "%llu,%.17g,%.17g,%.17g\n", static_cast<unsigned long long>(sample.tick),
                  sample.position, sample.force, sample.mass);
    out << row;
  }
}

void WriteSession(const RecordedSession& session, const std::filesystem::path& file, bool end) {
  record::SessionInfo begun = session.info;
  begun.state = record::SessionState::kOpen;
  begun.end_wall_ns.reset();
  record::SessionFile writer(file, begun);
  for (const record::Event& event : session.events) {
    writer.Add(event);
  }
  for (const record::Marker& marker : session.markers) {
    writer.Add(marker);
  }
  constexpr std::size_t kAtOnce = 4096;
  for (std::size_t k = 0; k < session.samples.size(); k += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, session.samples.size() - k);
    writer.Append({session.samples.data() + k, count}, "lost in a test");
    writer.Commit(record::Durability::kProcess);
  }
  if (end) {
    writer.End(record::SessionState::kEnded, session.info.end_wall_ns);
  }
}

// What somebody who does not mean well might write into a label.
void MakeHostile(RecordedSession& session) {
  const std::string hostile =
      "<script>alert('x')</script>\"'&<img src=http://evil.example/x onerror=alert(1)>\xff";
  session.info.labels.operator_name = hostile;
  session.info.labels.metadata["</table>"] = hostile;
  session.info.axis.name = hostile;
  session.info.provenance.configuration = "</pre></details>" + hostile;
  session.info.provenance.command_line = hostile;
  for (record::Marker& marker : session.markers) {
    marker.label = hostile;
    marker.metadata["</style>"] = hostile;
  }
  for (record::Event& event : session.events) {
    event.message = hostile;
  }
}

}  // namespace
}  // namespace mwidth::cli::session

int main(int argc, char** argv) {
  using namespace mwidth::cli::session;
  const std::vector<std::string> options(argv + 2, argv + argc);
  const auto given = [&options](const char* name) {
    return std::find(options.begin(), options.end(), name) != options.end();
  };
  const std::filesystem::path folder = argv[1];
  RecordedSession session = ReachSession({.marked = !given("--unmarked")}).Record();
  if (given("--hostile")) {
    MakeHostile(session);
  }
  if (given("--lossy")) {
    session.samples.erase(session.samples.begin() + 5000, session.samples.begin() + 5400);
  }
  if (given("--altered")) {
    mwidth::exchange::Sample& sample = session.samples[20'000];
    sample.force = ++sample.force_counts * session.info.axis.force_quantum;
  }
  WriteCsv(session, folder / "samples.csv");
  WriteSession(session, folder / (session.info.id + ".sqlite"), !given("--open"));
}
