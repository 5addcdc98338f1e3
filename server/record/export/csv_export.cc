#include "server/record/export/columns.h"
#include "server/record/export/export.h"
#include "server/record/export/session_json.h"
#include "server/record/export/text.h"
#include "server/record/session/session_schema.h"

namespace mwidth::record {
namespace {

namespace fs = std::filesystem;

uint64_t WriteSamples(SessionReader& reader, const std::vector<Column>& columns, const fs::path& file) {
  TextFile out(file);
  std::string text;
  for (const Column& column : columns) {
    text += (text.empty() ? "" : ",") + column.csv_name;
  }
  text += '\n';
  uint64_t count = 0;
  reader.Seek(0);
  for (std::vector<exchange::Sample> samples; reader.Next(samples); count += samples.size()) {
    for (const exchange::Sample& sample : samples) {
      for (const Column& column : columns) {
        AppendValue(text, column.of(sample));
        text += ',';
      }
      text.back() = '\n';
    }
    out.Write(text);
    text.clear();
  }
  out.Write(text);
  out.Close();
  return count;
}

void WriteEvents(const std::vector<Event>& events, const fs::path& file) {
  TextFile out(file);
  out.Write("number,kind,tick,monotonic_ns,message,metadata\n");
  for (const Event& event : events) {
    out.Write(std::to_string(event.number) + ',' + std::string(KindWord(event.kind)) + ',' +
              std::to_string(event.tick) + ',' + std::to_string(event.monotonic_ns) + ',' +
              CsvCell(event.message) + ',' + CsvCell(MetadataText(event.metadata)) + '\n');
  }
  out.Close();
}

void WriteMarkers(const std::vector<Marker>& markers, const fs::path& file) {
  TextFile out(file);
  out.Write("number,kind,label,monotonic_ns,error_ns,arrival_ns,client_ns,metadata\n");
  for (const Marker& marker : markers) {
    out.Write(std::to_string(marker.number) + ',' + CsvCell(marker.kind) + ',' + CsvCell(marker.label) + ',' +
              std::to_string(marker.monotonic_ns) + ',' + std::to_string(marker.error_ns) + ',' +
              std::to_string(marker.arrival_ns) + ',' + std::to_string(marker.client_ns) + ',' +
              CsvCell(MetadataText(marker.metadata)) + '\n');
  }
  out.Close();
}

void WriteGaps(const std::vector<Gap>& gaps, const fs::path& file) {
  TextFile out(file);
  out.Write("after_tick,before_tick,missed_ticks,lost_ticks,reason\n");
  for (const Gap& gap : gaps) {
    out.Write(std::to_string(gap.after_tick) + ',' + std::to_string(gap.before_tick) + ',' +
              std::to_string(gap.missed_ticks) + ',' + std::to_string(gap.lost_ticks) + ',' +
              CsvCell(gap.reason) + '\n');
  }
  out.Close();
}

nlohmann::ordered_json ColumnsJson(const std::vector<Column>& columns) {
  auto json = nlohmann::ordered_json::array();
  for (const Column& column : columns) {
    json.push_back({{"name", column.csv_name}, {"units", column.units}, {"description", column.description}});
  }
  return json;
}

}  // namespace

ExportReport ExportCsv(SessionReader& reader, const fs::path& folder, bool overwrite) {
  FileSet files(overwrite);
  const fs::path samples = files.Add(folder / "samples.csv");
  const fs::path events = files.Add(folder / "events.csv");
  const fs::path markers = files.Add(folder / "markers.csv");
  const fs::path gaps = files.Add(folder / "gaps.csv");
  const fs::path session = files.Add(folder / "session.json");

  const auto columns = SampleColumns(reader.info().axis.rotary);
  ExportReport report;
  report.samples = WriteSamples(reader, columns, samples);
  report.damaged = reader.damaged();
  WriteEvents(reader.Events(), events);
  WriteMarkers(reader.Markers(), markers);
  // After the samples: damaged blocks are gaps, too, and are known now.
  WriteGaps(reader.Gaps(), gaps);

  auto json = SessionJson(reader.info());
  json["wall_clock_steps"] = ToJson(reader.WallClockSteps());
  // Fewer than the session's where blocks are damaged, more where it was still being recorded.
  json["exported_samples"] = report.samples;
  json["damaged_blocks"] = ToJson(report.damaged);
  json["columns"] = ColumnsJson(columns);
  WriteText(session, Indented(json));
  files.Commit();
  report.files = files.Paths();
  return report;
}

}  // namespace mwidth::record
