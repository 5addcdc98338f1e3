#include <algorithm>
#include <iostream>
#include <optional>

#include "client/cli/commands.h"
#include "client/cli/plot/table.h"
#include "client/cli/session/session_files.h"
#include "client/cli/session/verbs.h"
#include "client/cli/session/words.h"
#include "server/record/export/session_json.h"

namespace mwidth::cli::session {
namespace {

struct Entry {
  std::filesystem::path file;
  /// None: the file cannot be read, `problem` says why.
  std::optional<record::SessionInfo> info;
  std::vector<record::Gap> gaps;
  std::string problem;
};

Entry Read(const std::filesystem::path& file) {
  try {
    const record::SessionReader reader(file);
    return {.file = file, .info = reader.info(), .gaps = reader.Gaps(), .problem = {}};
  } catch (const record::SessionFileError& error) {
    return {.file = file, .info = std::nullopt, .gaps = {}, .problem = error.what()};
  }
}

nlohmann::ordered_json Json(const Entry& entry) {
  nlohmann::ordered_json json;
  if (entry.info) {
    json = record::SummaryJson(*entry.info);
    uint64_t missed = 0;
    uint64_t lost = 0;
    for (const auto& gap : entry.gaps) {
      missed += gap.missed_ticks;
      lost += gap.lost_ticks;
    }
    json["missed_ticks"] = missed;
    json["lost_ticks"] = lost;
  } else {
    json = {{"session", entry.file.stem().string()}, {"state", "unreadable"}, {"message", entry.problem}};
  }
  json["file"] = entry.file.string();
  return json;
}

std::vector<std::string> Row(const Entry& entry) {
  if (!entry.info) {
    return {entry.file.stem().string(), "unreadable", "-", "-", "-", "-", "-", "-", "-"};
  }
  const auto& info = *entry.info;
  const auto& labels = info.labels;
  return {info.id,
          std::string(StateWord(info.state)),
          labels.subject + (labels.visit.empty() ? "" : "/" + labels.visit),
          labels.task,
          std::to_string(labels.run),
          Moment(info.start_wall_ns),
          Duration(info),
          std::to_string(info.sample_count),
          GapText(entry.gaps)};
}

void PrintText(const std::vector<Entry>& entries, const std::string& folder) {
  if (entries.empty()) {
    std::cout << "No sessions in " << folder << "\n";
    return;
  }
  plot::Table table{.title = "",
                    .columns = {"session", "state", "subject", "task", "run", "start", "duration", "samples",
                                "ticks gone"}};
  for (const Entry& entry : entries) {
    table.rows.push_back(Row(entry));
  }
  std::cout << ToText(table);
  for (const Entry& entry : entries) {
    if (!entry.problem.empty()) {
      std::cerr << entry.problem << "\n";
    }
  }
}

}  // namespace

int List(const CommandLine& line) {
  std::vector<Entry> entries;
  for (const auto& file : AllFiles(line.session)) {
    entries.push_back(Read(file));
  }
  // The newest first; what cannot be read, last.
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return (a.info ? a.info->start_wall_ns : INT64_MIN) > (b.info ? b.info->start_wall_ns : INT64_MIN);
  });
  if (line.json) {
    auto json = nlohmann::ordered_json::array();
    for (const Entry& entry : entries) {
      json.push_back(Json(entry));
    }
    std::cout << record::Indented(json);
  } else {
    PrintText(entries, line.session.folder);
  }
  return kDone;
}

}  // namespace mwidth::cli::session
