#include "client/cli/session/words.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "client/cli/numbers.h"
#include "client/cli/one_line.h"
#include "client/cli/plot/table.h"
#include "server/record/export/session_json.h"
#include "server/record/export/text.h"

namespace mwidth::cli::session {
namespace {

using record::SessionInfo;

constexpr size_t kNameWidth = 12;

std::string Line(const std::string& name, const std::string& value) {
  return "  " + name + std::string(kNameWidth > name.size() ? kNameWidth - name.size() : 1, ' ') + value +
         "\n";
}

// Seconds since the session's start.
std::string Since(const SessionInfo& info, int64_t monotonic_ns) {
  std::array<char, 32> text{};
  const int length = std::snprintf(text.data(), text.size(), "%.3f",
                                   1e-9 * static_cast<double>(monotonic_ns - info.start_monotonic_ns));
  return {text.data(), static_cast<size_t>(length)};
}

std::string Pairs(const std::map<std::string, std::string>& metadata) {
  std::string text;
  for (const auto& [key, value] : metadata) {
    text += text.empty() ? "" : ", ";
    text += key;
    text += '=';
    text += value;
  }
  return text;
}

// Indented by two, below an empty line and its name.
std::string Section(const std::string& name, const std::string& text) {
  std::string section = "\n" + name + "\n  ";
  for (size_t i = 0; i < text.size(); ++i) {
    section += text[i];
    section += text[i] == '\n' && i + 1 < text.size() ? "  " : "";
  }
  return section.ends_with('\n') ? section : section + "\n";
}

std::string Head(const SessionInfo& info, const std::vector<record::Gap>& gaps) {
  const auto& labels = info.labels;
  const auto& axis = info.axis;
  std::string text = info.id + ", " + std::string(StateWord(info.state)) + "\n";
  text += Line("subject", labels.subject + (labels.visit.empty() ? "" : ", visit " + labels.visit));
  text += Line("task", labels.task + ", run " + std::to_string(labels.run));
  if (!labels.operator_name.empty()) {
    text += Line("operator", OneLine(labels.operator_name));
  }
  text += Line("axis", axis.name + ", " + (axis.rotary ? "rotary" : "linear") + ", " +
                           Rounded(1 / axis.period_s) + " Hz");
  text += Line("start", Moment(info.start_wall_ns));
  text += Line("end", Moment(info.end_wall_ns));
  text += Line("duration", Duration(info));
  text += Line("samples", std::to_string(info.sample_count) +
                              (info.sample_count == 0 ? ""
                                                      : ", ticks " + std::to_string(info.first_tick) +
                                                            " to " + std::to_string(info.last_tick)));
  text += Line("ticks gone", GapText(gaps));
  text += Line("software", "mwidthd " + info.provenance.software_version);
  text += Line("started as", info.provenance.command_line);
  return text;
}

plot::Table MarkerTable(const SessionInfo& info, const std::vector<record::Marker>& markers) {
  plot::Table table{.title = "Markers", .columns = {"time, s", "kind", "label", "to within, ms", "metadata"}};
  for (const auto& marker : markers) {
    table.rows.push_back({Since(info, marker.monotonic_ns), OneLine(marker.kind), OneLine(marker.label),
                          Rounded(1e-6 * static_cast<double>(marker.error_ns), 3),
                          OneLine(Pairs(marker.metadata))});
  }
  return table;
}

plot::Table EventTable(const SessionInfo& info, const std::vector<record::Event>& events) {
  plot::Table table{.title = "Events", .columns = {"time, s", "tick", "kind", "message"}};
  for (const auto& event : events) {
    table.rows.push_back({Since(info, event.monotonic_ns), std::to_string(event.tick),
                          std::string(KindWord(event.kind)), OneLine(event.message)});
  }
  return table;
}

plot::Table GapTable(const std::vector<record::Gap>& gaps) {
  plot::Table table{.title = "Gaps", .columns = {"after tick", "before tick", "missed", "lost", "reason"}};
  for (const auto& gap : gaps) {
    table.rows.push_back({std::to_string(gap.after_tick), std::to_string(gap.before_tick),
                          std::to_string(gap.missed_ticks), std::to_string(gap.lost_ticks),
                          OneLine(gap.reason)});
  }
  return table;
}

}  // namespace

std::string Moment(const std::optional<int64_t>& wall_ns) {
  if (!wall_ns) {
    return "-";
  }
  std::string text = record::UtcTime(*wall_ns);
  text.replace(text.find('T'), 1, " ");
  return text.substr(0, text.find('.')) + " UTC";
}

std::string Duration(const SessionInfo& info) {
  if (info.sample_count == 0) {
    return "-";
  }
  const double seconds = static_cast<double>(info.last_tick - info.first_tick + 1) * info.axis.period_s;
  if (seconds < 60) {
    return Rounded(seconds, 5) + " s";
  }
  const auto whole = std::llround(seconds);
  std::array<char, 32> text{};
  const int length = std::snprintf(text.data(), text.size(), "%lld:%02lld:%02lld", whole / 3600,
                                   whole / 60 % 60, whole % 60);
  return {text.data(), static_cast<size_t>(length)};
}

std::string GapText(const std::vector<record::Gap>& gaps) {
  const auto [missed, lost] = record::TotalsOf(gaps);
  return missed + lost == 0 ? "none" : std::to_string(missed) + " missed, " + std::to_string(lost) + " lost";
}

std::string Report(const record::SessionReader& reader) {
  const SessionInfo& info = reader.info();
  const auto gaps = reader.Gaps();
  std::string text = Head(info, gaps);
  if (!info.labels.metadata.empty()) {
    plot::Table table{.title = "Metadata", .columns = {"key", "value"}};
    for (const auto& [key, value] : info.labels.metadata) {
      table.rows.push_back({OneLine(key), OneLine(value)});
    }
    text += Section(table.title, ToText(table));
  }
  for (const plot::Table& table :
       {MarkerTable(info, reader.Markers()), EventTable(info, reader.Events()), GapTable(gaps)}) {
    if (!table.rows.empty()) {
      text += Section(table.title, ToText(table));
    }
  }
  for (const auto& step : reader.WallClockSteps()) {
    text += "\nThe wall clock was set at " + Since(info, step.monotonic_ns) + " s, to " +
            Moment(step.monotonic_ns + step.offset_ns) + "\n";
  }
  text += Section("Axis at the start", info.provenance.axis_state);
  return text + Section("Configuration", info.provenance.configuration);
}

}  // namespace mwidth::cli::session
