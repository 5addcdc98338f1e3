#include <iostream>

#include "client/cli/commands.h"
#include "client/cli/session/session_files.h"
#include "client/cli/session/verbs.h"
#include "client/cli/session/words.h"
#include "server/record/export/session_json.h"

namespace mwidth::cli::session {

int Show(const CommandLine& line) {
  const auto file = FileOf(line.session, line.session.sessions.front());
  const record::SessionReader reader(file);
  if (!line.json) {
    std::cout << Report(reader);
    return kDone;
  }
  auto json = record::SessionJson(reader.info());
  json["file_bytes"] = std::filesystem::file_size(file);
  json["markers"] = record::ToJson(reader.Markers());
  json["events"] = record::ToJson(reader.Events());
  json["gaps"] = record::ToJson(reader.Gaps());
  json["wall_clock_steps"] = record::ToJson(reader.WallClockSteps());
  std::cout << record::Indented(json);
  return kDone;
}

}  // namespace mwidth::cli::session
