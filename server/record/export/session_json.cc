#include "server/record/export/session_json.h"

#include <array>

#include "server/record/export/text.h"

namespace mwidth::record {
namespace {

using Json = nlohmann::ordered_json;

// What people write for machines is shown as what it is; what is no JSON stays text.
Json Parsed(const std::string& text) {
  Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  return json.is_discarded() ? Json(text) : json;
}

Json LabelsJson(const SessionLabels& labels) {
  return {{"subject", labels.subject},
          {"visit", labels.visit},
          {"task", labels.task},
          {"run", labels.run},
          {"operator", labels.operator_name},
          {"metadata", labels.metadata}};
}

Json AxisJson(const SessionAxis& axis) {
  // JSON has no infinity: nlohmann writes null, which says that there is no limit.
  return {{"name", axis.name},
          {"kind", axis.rotary ? "rotary" : "linear"},
          {"period_s", axis.period_s},
          {"position_quantum", axis.position_quantum},
          {"force_quantum", axis.force_quantum},
          {"acceleration_quantum", axis.acceleration_quantum},
          {"force_limit", axis.force_limit},
          {"force_slew_limit", axis.force_slew_limit}};
}

}  // namespace

std::string_view StateWord(SessionState state) {
  switch (state) {
    case SessionState::kOpen:
      return "open";
    case SessionState::kEnded:
      return "ended";
    case SessionState::kRecovered:
      return "recovered";
  }
  return "unknown";
}

std::string_view KindWord(EventKind kind) {
  static constexpr std::array<std::string_view, 18> kWords{
      "unknown",          "state_changed",      "fault",           "emergency_stop", "control_acquired",
      "control_released", "mass_set",           "mass_refused",    "filter_set",     "filter_refused",
      "ticks_missed",     "samples_dropped",    "session_started", "session_ended",  "storage_failed",
      "storage_restored", "wall_clock_stepped", "server_stopping"};
  const auto index = static_cast<size_t>(kind);
  return index < kWords.size() ? kWords[index] : kWords[0];
}

Json SummaryJson(const SessionInfo& info) {
  Json json{{"session", info.id},
            {"state", StateWord(info.state)},
            {"axis", info.axis.name},
            {"labels", LabelsJson(info.labels)},
            {"start_time", UtcTime(info.start_wall_ns)},
            {"end_time", nullptr},
            {"start_wall_ns", info.start_wall_ns},
            {"end_wall_ns", nullptr},
            {"start_monotonic_ns", info.start_monotonic_ns},
            {"samples", info.sample_count},
            {"first_tick", info.first_tick},
            {"last_tick", info.last_tick}};
  if (info.end_wall_ns) {
    json["end_time"] = UtcTime(*info.end_wall_ns);
    json["end_wall_ns"] = *info.end_wall_ns;
  }
  return json;
}

Json SessionJson(const SessionInfo& info) {
  Json json = SummaryJson(info);
  json["axis"] = AxisJson(info.axis);
  json["software_version"] = info.provenance.software_version;
  json["command_line"] = info.provenance.command_line;
  json["configuration"] = info.provenance.configuration;
  json["axis_state"] = Parsed(info.provenance.axis_state);
  return json;
}

Json ToJson(const std::vector<Event>& events) {
  Json json = Json::array();
  for (const Event& event : events) {
    json.push_back({{"number", event.number},
                    {"kind", KindWord(event.kind)},
                    {"tick", event.tick},
                    {"monotonic_ns", event.monotonic_ns},
                    {"message", event.message},
                    {"metadata", event.metadata}});
  }
  return json;
}

Json ToJson(const std::vector<Marker>& markers) {
  Json json = Json::array();
  for (const Marker& marker : markers) {
    json.push_back({{"number", marker.number},
                    {"kind", marker.kind},
                    {"label", marker.label},
                    {"monotonic_ns", marker.monotonic_ns},
                    {"error_ns", marker.error_ns},
                    {"arrival_ns", marker.arrival_ns},
                    {"client_ns", marker.client_ns},
                    {"metadata", marker.metadata}});
  }
  return json;
}

Json ToJson(const std::vector<Gap>& gaps) {
  Json json = Json::array();
  for (const Gap& gap : gaps) {
    json.push_back({{"after_tick", gap.after_tick},
                    {"before_tick", gap.before_tick},
                    {"missed_ticks", gap.missed_ticks},
                    {"lost_ticks", gap.lost_ticks},
                    {"reason", gap.reason}});
  }
  return json;
}

Json ToJson(const std::vector<WallClockStep>& steps) {
  Json json = Json::array();
  for (const WallClockStep& step : steps) {
    json.push_back({{"monotonic_ns", step.monotonic_ns}, {"offset_ns", step.offset_ns}});
  }
  return json;
}

Json ToJson(const std::vector<DamagedBlock>& damaged) {
  Json json = Json::array();
  for (const DamagedBlock& block : damaged) {
    json.push_back({{"block", block.number},
                    {"first_tick", block.first_tick},
                    {"last_tick", block.last_tick},
                    {"reason", block.reason}});
  }
  return json;
}

std::string Indented(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace mwidth::record
