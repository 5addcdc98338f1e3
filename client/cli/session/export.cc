#include "server/record/export/export.h"

#include <algorithm>
#include <iostream>

#include "client/cli/commands.h"
#include "client/cli/session/session_files.h"
#include "client/cli/session/verbs.h"
#include "server/record/export/session_json.h"

namespace mwidth::cli::session {
namespace {

record::ExportReport ExportOne(record::SessionReader& reader, const SessionOptions& options) {
  const std::filesystem::path to = options.to;
  if (options.format == "csv") {
    return record::ExportCsv(reader, to / reader.info().id, options.force);
  }
  if (options.format == "hdf5") {
    return record::ExportHdf5(reader, to / (reader.info().id + ".h5"), options.force);
  }
  return record::ExportBids(reader, to, options.force);
}

nlohmann::ordered_json Json(const record::SessionInfo& info, const record::ExportReport& report) {
  auto files = nlohmann::ordered_json::array();
  for (const auto& file : report.files) {
    files.push_back(file.string());
  }
  return {{"session", info.id},
          {"samples", report.samples},
          {"files", files},
          {"damaged_blocks", record::ToJson(report.damaged)}};
}

void PrintText(const record::SessionInfo& info, const record::ExportReport& report) {
  std::cout << info.id << ": " << report.samples << " samples, " << report.files.front().string()
            << (report.files.size() > 1 ? " and " + std::to_string(report.files.size() - 1) + " files more"
                                        : "")
            << "\n";
}

}  // namespace

int Export(const CommandLine& line) {
  int code = kDone;
  auto json = nlohmann::ordered_json::array();
  for (const std::string& name : line.session.sessions) {
    record::SessionReader reader(FileOf(line.session, name));
    try {
      const auto report = ExportOne(reader, line.session);
      json.push_back(Json(reader.info(), report));
      if (!line.json) {
        PrintText(reader.info(), report);
      }
      for (const auto& block : report.damaged) {
        std::cerr << reader.info().id << ": block " << block.number << ", ticks " << block.first_tick
                  << " to " << block.last_tick << ", is left out: " << block.reason << "\n";
      }
      code = std::max<int>(code, report.damaged.empty() ? kDone : kRefused);
    } catch (const record::ExportRefused& refusal) {
      // The others are exported.
      std::cerr << "mwidth: " << refusal.what() << "\n";
      code = kRefused;
    }
  }
  if (line.json) {
    std::cout << record::Indented(json);
  }
  return code;
}

}  // namespace mwidth::cli::session
