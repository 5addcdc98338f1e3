#include <iostream>

#include "client/cli/commands.h"
#include "client/cli/session/session_files.h"
#include "client/cli/session/verbs.h"
#include "server/record/export/session_json.h"

namespace mwidth::cli::session {
namespace {

// A file that is no session any more is damaged as a whole.
std::vector<record::DamagedBlock> Check(const std::filesystem::path& file) {
  try {
    return record::SessionReader(file).Verify();
  } catch (const record::SessionFileError& error) {
    return {{.number = 0, .first_tick = 0, .last_tick = 0, .reason = error.what()}};
  }
}

void PrintText(const std::string& name, const std::vector<record::DamagedBlock>& damaged) {
  if (damaged.empty()) {
    std::cout << name << ": sound\n";
  }
  for (const auto& block : damaged) {
    // Block 0: what is in no block of its own yet, or the file as a whole.
    std::cout << name << ": " << (block.number == 0 ? "" : "block " + std::to_string(block.number) + ", ")
              << (block.first_tick == 0 ? ""
                                        : "ticks " + std::to_string(block.first_tick) + " to " +
                                              std::to_string(block.last_tick) + ": ")
              << block.reason << "\n";
  }
}

}  // namespace

int Verify(const CommandLine& line) {
  bool sound = true;
  auto json = nlohmann::ordered_json::array();
  for (const std::string& name : line.session.sessions) {
    const auto file = FileOf(line.session, name);
    const auto damaged = Check(file);
    sound = sound && damaged.empty();
    if (line.json) {
      json.push_back({{"session", file.stem().string()},
                      {"file", file.string()},
                      {"sound", damaged.empty()},
                      {"damaged_blocks", record::ToJson(damaged)}});
    } else {
      PrintText(file.stem().string(), damaged);
    }
  }
  if (line.json) {
    std::cout << record::Indented(json);
  }
  return sound ? kDone : kRefused;
}

}  // namespace mwidth::cli::session
