// The layout: samples in columns under /samples, one dataset each with its units and its meaning; events,
// markers, gaps, steps of the wall clock and damaged blocks as groups of columns of equal length; what the
// session says of itself as attributes of the root, and the long texts as datasets.
#include <cmath>
#include <functional>

#include "server/record/export/columns.h"
#include "server/record/export/export.h"
#include "server/record/export/hdf5_file.h"
#include "server/record/export/session_json.h"
#include "server/record/export/text.h"
#include "server/record/session/session_schema.h"

namespace mwidth::record {
namespace {

namespace fs = std::filesystem;

// "0 idle, 1 ready": for columns whose numbers stand for words.
std::string Legend(const Column& column) {
  std::string legend;
  for (size_t code = 0; code < column.words.size(); ++code) {
    legend += (code == 0 ? "" : ", ") + std::to_string(code) + ' ' + std::string(column.words[code]);
  }
  return legend;
}

uint64_t WriteSamples(SessionReader& reader, Hdf5File& file) {
  file.Group("/samples");
  const auto columns = SampleColumns(reader.info().axis.rotary);
  std::vector<size_t> series;
  for (const Column& column : columns) {
    const std::string path = "/samples/" + column.name;
    series.push_back(file.Series(path, column.of({})));
    file.Attribute(path, "units", column.units);
    file.Attribute(path, "description", column.description);
    if (!column.words.empty()) {
      file.Attribute(path, "values", Legend(column));
    }
  }
  uint64_t count = 0;
  reader.Seek(0);
  for (std::vector<exchange::Sample> samples; reader.Next(samples); count += samples.size()) {
    for (size_t i = 0; i < columns.size(); ++i) {
      for (const exchange::Sample& sample : samples) {
        file.Append(series[i], columns[i].of(sample));
      }
    }
  }
  return count;
}

// One column of a table, from one field of each of its rows.
template <typename Row, typename Field>
void AddColumn(Hdf5File& file, const std::string& path, const std::vector<Row>& rows, const Field& field) {
  using T = std::decay_t<std::invoke_result_t<Field, const Row&>>;
  std::vector<T> values;
  values.reserve(rows.size());
  for (const Row& row : rows) {
    values.push_back(std::invoke(field, row));
  }
  if constexpr (std::is_same_v<T, std::string>) {
    file.Texts(path, values);
  } else {
    file.Numbers(path, values);
  }
}

void WriteEvents(Hdf5File& file, const std::vector<Event>& events) {
  file.Group("/events");
  AddColumn(file, "/events/number", events, &Event::number);
  AddColumn(file, "/events/kind", events, [](const Event& e) { return std::string(KindWord(e.kind)); });
  AddColumn(file, "/events/tick", events, &Event::tick);
  AddColumn(file, "/events/monotonic_ns", events, &Event::monotonic_ns);
  AddColumn(file, "/events/message", events, &Event::message);
  AddColumn(file, "/events/metadata", events, [](const Event& e) { return MetadataText(e.metadata); });
}

void WriteMarkers(Hdf5File& file, const std::vector<Marker>& markers) {
  file.Group("/markers");
  AddColumn(file, "/markers/number", markers, &Marker::number);
  AddColumn(file, "/markers/kind", markers, &Marker::kind);
  AddColumn(file, "/markers/label", markers, &Marker::label);
  AddColumn(file, "/markers/monotonic_ns", markers, &Marker::monotonic_ns);
  AddColumn(file, "/markers/error_ns", markers, &Marker::error_ns);
  AddColumn(file, "/markers/arrival_ns", markers, &Marker::arrival_ns);
  AddColumn(file, "/markers/client_ns", markers, &Marker::client_ns);
  AddColumn(file, "/markers/metadata", markers, [](const Marker& m) { return MetadataText(m.metadata); });
}

void WriteLosses(Hdf5File& file, const std::vector<Gap>& gaps, const std::vector<DamagedBlock>& damaged) {
  file.Group("/gaps");
  AddColumn(file, "/gaps/after_tick", gaps, &Gap::after_tick);
  AddColumn(file, "/gaps/before_tick", gaps, &Gap::before_tick);
  AddColumn(file, "/gaps/missed_ticks", gaps, &Gap::missed_ticks);
  AddColumn(file, "/gaps/lost_ticks", gaps, &Gap::lost_ticks);
  AddColumn(file, "/gaps/reason", gaps, &Gap::reason);
  file.Group("/damaged_blocks");
  AddColumn(file, "/damaged_blocks/number", damaged, &DamagedBlock::number);
  AddColumn(file, "/damaged_blocks/first_tick", damaged, &DamagedBlock::first_tick);
  AddColumn(file, "/damaged_blocks/last_tick", damaged, &DamagedBlock::last_tick);
  AddColumn(file, "/damaged_blocks/reason", damaged, &DamagedBlock::reason);
}

void WriteSteps(Hdf5File& file, const std::vector<WallClockStep>& steps) {
  file.Group("/wall_clock_steps");
  AddColumn(file, "/wall_clock_steps/monotonic_ns", steps, &WallClockStep::monotonic_ns);
  AddColumn(file, "/wall_clock_steps/offset_ns", steps, &WallClockStep::offset_ns);
}

void WriteAxis(Hdf5File& file, const SessionAxis& axis) {
  file.Attribute("/", "axis", axis.name);
  file.Attribute("/", "axis_kind", axis.rotary ? "rotary" : "linear");
  file.Attribute("/", "period_s", axis.period_s);
  file.Attribute("/", "position_quantum", axis.position_quantum);
  file.Attribute("/", "force_quantum", axis.force_quantum);
  file.Attribute("/", "acceleration_quantum", axis.acceleration_quantum);
  file.Attribute("/", "force_limit", axis.force_limit);
  file.Attribute("/", "force_slew_limit", axis.force_slew_limit);
}

void WriteSession(Hdf5File& file, const SessionInfo& info) {
  file.Attribute("/", "format", "mwidth session");
  file.Attribute("/", "format_version", uint64_t{1});
  file.Attribute("/", "session", info.id);
  file.Attribute("/", "state", StateWord(info.state));
  file.Attribute("/", "subject", info.labels.subject);
  file.Attribute("/", "visit", info.labels.visit);
  file.Attribute("/", "task", info.labels.task);
  file.Attribute("/", "run", int64_t{info.labels.run});
  file.Attribute("/", "operator", info.labels.operator_name);
  WriteAxis(file, info.axis);
  file.Attribute("/", "start_time", UtcTime(info.start_wall_ns));
  file.Attribute("/", "start_wall_ns", info.start_wall_ns);
  file.Attribute("/", "start_monotonic_ns", info.start_monotonic_ns);
  if (info.end_wall_ns) {
    file.Attribute("/", "end_time", UtcTime(*info.end_wall_ns));
    file.Attribute("/", "end_wall_ns", *info.end_wall_ns);
  }
  file.Attribute("/", "software_version", info.provenance.software_version);
  file.Attribute("/", "command_line", info.provenance.command_line);
  file.Text("/configuration", info.provenance.configuration);
  file.Text("/axis_state", info.provenance.axis_state);
  file.Text("/metadata", MetadataText(info.labels.metadata));
}

}  // namespace

ExportReport ExportHdf5(SessionReader& reader, const fs::path& file, bool overwrite) {
  FileSet files(overwrite);
  const fs::path temporary = files.Add(file);
  ExportReport report;
  {
    Hdf5File out(temporary, file.string());
    WriteSession(out, reader.info());
    report.samples = WriteSamples(reader, out);
    report.damaged = reader.damaged();
    WriteEvents(out, reader.Events());
    WriteMarkers(out, reader.Markers());
    // After the samples: damaged blocks are gaps, too, and are known now.
    WriteLosses(out, reader.Gaps(), report.damaged);
    WriteSteps(out, reader.WallClockSteps());
    out.Close();
  }
  files.Commit();
  report.files = files.Paths();
  return report;
}

}  // namespace mwidth::record
