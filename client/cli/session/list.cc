#include <iostream>
#include <utility>

#include "client/cli/commands.h"
#include "client/cli/plot/table.h"
#include "client/cli/session/session_files.h"
#include "client/cli/session/verbs.h"
#include "client/cli/session/words.h"
#include "server/record/export/session_json.h"

namespace mwidth::cli::session {
namespace {

struct Entry {
  record::StoredSession stored;
  std::vector<record::Gap> gaps;
};

// What a server writes now is "recording"; "open" is left to what needs to be recovered.
std::string State(const record::StoredSession& stored) {
  if (!stored.info) {
    return "unreadable";
  }
  return stored.recording && stored.info->state == record::SessionState::kOpen
             ? "recording"
             : std::string(StateWord(stored.info->state));
}

// Those that the server noted: damage, which shows only when every block is read, is for verify.
void ReadGaps(Entry& entry) {
  if (!entry.stored.info) {
    return;
  }
  try {
    entry.gaps = record::SessionReader(entry.stored.file).NotedGaps();
  } catch (const record::SessionFileError& error) {
    entry.stored.problem = error.what();
  }
}

nlohmann::ordered_json Json(const Entry& entry) {
  nlohmann::ordered_json json;
  const auto& stored = entry.stored;
  if (stored.info) {
    json = record::SummaryJson(*stored.info);
    json["state"] = State(stored);
    const record::GapTotals totals = record::TotalsOf(entry.gaps);
    json["missed_ticks"] = totals.missed_ticks;
    json["lost_ticks"] = totals.lost_ticks;
  } else {
    json = {{"session", stored.id}, {"state", State(stored)}, {"message", stored.problem}};
  }
  json["file"] = stored.file.string();
  json["file_bytes"] = stored.file_bytes;
  return json;
}

std::vector<std::string> Row(const Entry& entry) {
  if (!entry.stored.info) {
    return {entry.stored.id, State(entry.stored), "-", "-", "-", "-", "-", "-", "-"};
  }
  const auto& info = *entry.stored.info;
  const auto& labels = info.labels;
  return {info.id,
          State(entry.stored),
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
    if (!entry.stored.problem.empty()) {
      std::cerr << entry.stored.problem << "\n";
    }
  }
}

}  // namespace

int List(const CommandLine& line) {
  std::vector<Entry> entries;
  for (auto& stored : AllSessions(line.session)) {
    Entry entry{.stored = std::move(stored), .gaps = {}};
    ReadGaps(entry);
    entries.push_back(std::move(entry));
  }
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
