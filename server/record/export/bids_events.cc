#include "server/record/export/bids_events.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "server/record/export/session_json.h"
#include "server/record/export/text.h"
#include "server/record/session/session_schema.h"

namespace mwidth::record {
namespace {

struct Row {
  int64_t onset_ns = 0;
  std::optional<int64_t> duration_ns;
  std::string trial_type;
  std::string label;
  std::optional<int64_t> error_ns;
  std::string message;
  std::string metadata;
  std::string end_label;
  std::string end_metadata;
};

// Nanoseconds as seconds, exactly.
std::string Seconds(const std::optional<int64_t>& time_ns) {
  if (!time_ns) {
    return "n/a";
  }
  constexpr uint64_t kSecond = 1'000'000'000;
  const auto magnitude =
      *time_ns < 0 ? uint64_t{0} - static_cast<uint64_t>(*time_ns) : static_cast<uint64_t>(*time_ns);
  const std::string fraction = std::to_string(magnitude % kSecond);
  return (*time_ns < 0 ? "-" : "") + std::to_string(magnitude / kSecond) + '.' +
         std::string(9 - fraction.size(), '0') + fraction;
}

std::string Metadata(const std::map<std::string, std::string>& metadata) {
  return metadata.empty() ? "" : MetadataText(metadata);
}

Row RowOf(const Marker& marker, const MotionExtent& extent) {
  return {.onset_ns = marker.monotonic_ns - extent.first_monotonic_ns,
          .duration_ns = 0,
          .trial_type = marker.kind.empty() ? "marker" : marker.kind,
          .label = marker.label,
          .error_ns = marker.error_ns,
          .message = {},
          .metadata = Metadata(marker.metadata),
          .end_label = {},
          .end_metadata = {}};
}

void AddMarkers(std::vector<Row>& rows, std::vector<Marker> markers, const MotionExtent& extent) {
  std::stable_sort(markers.begin(), markers.end(),
                   [](const Marker& a, const Marker& b) { return a.monotonic_ns < b.monotonic_ns; });
  // Behind the row of the trial that has begun and not ended; 0 where none has.
  size_t open = 0;
  for (const Marker& marker : markers) {
    const Row row = RowOf(marker, extent);
    if (marker.kind == "trial_end" && open > 0) {
      Row& trial = rows[open - 1];
      trial.duration_ns = row.onset_ns - trial.onset_ns;
      trial.end_label = row.label;
      trial.end_metadata = row.metadata;
      open = 0;
      continue;
    }
    rows.push_back(row);
    if (marker.kind == "trial_start") {
      rows.back().trial_type = "trial";
      rows.back().duration_ns.reset();
      open = rows.size();
    }
  }
}

Row RowOf(const Gap& gap, const MotionExtent& extent, double period_s) {
  const uint64_t ticks = gap.missed_ticks + gap.lost_ticks;
  // A gap at the session's beginning has no tick before it.
  const uint64_t first = gap.after_tick > 0 ? gap.after_tick + 1 : gap.before_tick - ticks;
  const auto time_ns = [period_s](int64_t count) {
    return std::llround(1e9 * period_s * static_cast<double>(count));
  };
  return {.onset_ns = time_ns(static_cast<int64_t>(first - extent.first_tick)),
          .duration_ns = time_ns(static_cast<int64_t>(ticks)),
          .trial_type = "gap",
          .label = {},
          .error_ns = {},
          .message = std::to_string(gap.missed_ticks) + " ticks missed, " + std::to_string(gap.lost_ticks) +
                     " known to be lost" + (gap.reason.empty() ? "" : ": " + gap.reason),
          .metadata = {},
          .end_label = {},
          .end_metadata = {}};
}

Row RowOf(const Event& event, const MotionExtent& extent) {
  return {.onset_ns = event.monotonic_ns - extent.first_monotonic_ns,
          .duration_ns = 0,
          .trial_type = std::string(KindWord(event.kind)),
          .label = {},
          .error_ns = {},
          .message = event.message,
          .metadata = Metadata(event.metadata),
          .end_label = {},
          .end_metadata = {}};
}

}  // namespace

std::string EventsTsv(const std::vector<Marker>& markers, const std::vector<Event>& events,
                      const std::vector<Gap>& gaps, const MotionExtent& extent, double period_s) {
  std::vector<Row> rows;
  AddMarkers(rows, markers, extent);
  for (const Event& event : events) {
    rows.push_back(RowOf(event, extent));
  }
  for (const Gap& gap : gaps) {
    rows.push_back(RowOf(gap, extent, period_s));
  }
  std::stable_sort(rows.begin(), rows.end(),
                   [](const Row& a, const Row& b) { return a.onset_ns < b.onset_ns; });
  std::string text =
      "onset\tduration\ttrial_type\tlabel\tonset_error\tmessage\tmetadata\tend_label\tend_metadata\n";
  for (const Row& row : rows) {
    text += Seconds(row.onset_ns) + '\t' + Seconds(row.duration_ns) + '\t' + TsvCell(row.trial_type) + '\t' +
            TsvCell(row.label) + '\t' + Seconds(row.error_ns) + '\t' + TsvCell(row.message) + '\t' +
            TsvCell(row.metadata) + '\t' + TsvCell(row.end_label) + '\t' + TsvCell(row.end_metadata) + '\n';
  }
  return text;
}

std::string EventsJson(const std::string& software_version) {
  nlohmann::ordered_json json{
      {"onset", {{"Description", "Since the first sample"}, {"Units", "s"}}},
      {"duration",
       {{"Description", "Of trials and gaps; 0 for moments, n/a for trials without an end"}, {"Units", "s"}}},
      {"trial_type",
       {{"Description",
         "What it is: a trial, a gap, an event of the server, or the kind of a marker that the study set"},
        {"Levels",
         {{"trial", "From a marker of kind trial_start to the next of kind trial_end"},
          {"trial_end", "The end of a trial whose beginning was not marked"},
          {"marker", "A marker without a kind"},
          {"gap", "Ticks without a sample: rows of n/a in motion.tsv"},
          {"state_changed", "The axis went from one state to another"},
          {"fault", "The server stopped rendering: the message says why"},
          {"emergency_stop", "Somebody stopped the axis"},
          {"mass_set", "A virtual mass was admitted; the loop ramps to it"},
          {"mass_refused", "A virtual mass was refused; the old one stayed"},
          {"filter_set", "Acceleration is estimated otherwise from here on"}}}}},
      {"label", {{"Description", "The marker's label; of a trial, that of its beginning"}}},
      {"onset_error", {{"Description", "How far off the onset of a marker may be"}, {"Units", "s"}}},
      {"message", {{"Description", "What happened, for a person"}}},
      {"metadata",
       {{"Description", "Figures of an event, or what the study gave with a marker: a JSON object"}}},
      {"end_label", {{"Description", "The label of the marker that ended the trial"}}},
      {"end_metadata", {{"Description", "What the study gave with that marker: a JSON object"}}}};
  // Where the trials and markers come from, in the place that BIDS has for it.
  json["StimulusPresentation"] = {{"SoftwareName", "mwidthd"}, {"SoftwareVersion", software_version}};
  return Indented(json);
}

}  // namespace mwidth::record
