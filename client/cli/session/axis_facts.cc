#include "client/cli/session/axis_facts.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <nlohmann/json.hpp>

namespace mwidth::cli::session {
namespace {

using nlohmann::json;

// "device_mass" as protobuf's JSON has it: "deviceMass".
std::string CamelCase(const std::string& name) {
  std::string camel;
  for (std::size_t i = 0; i < name.size(); ++i) {
    if (name[i] == '_' && i + 1 < name.size()) {
      camel += static_cast<char>(std::toupper(static_cast<unsigned char>(name[++i])));
    } else {
      camel += name[i];
    }
  }
  return camel;
}

const json& Field(const json& message, const std::string& name) {
  static const json none;
  if (!message.is_object()) {
    return none;
  }
  for (const std::string& key : {name, CamelCase(name)}) {
    if (const auto field = message.find(key); field != message.end()) {
      return *field;
    }
  }
  return none;
}

std::optional<double> Number(const json& message, const std::string& name) {
  const json& field = Field(message, name);
  if (field.is_number()) {
    return field.get<double>();
  }
  if (field == "Infinity" || field == "-Infinity") {
    return (field == "Infinity" ? 1 : -1) * std::numeric_limits<double>::infinity();
  }
  return std::nullopt;
}

std::optional<MassRange> Range(const json& message, const std::string& name) {
  const json& interval = Field(message, name);
  const auto min = Number(interval, "min");
  const auto max = Number(interval, "max");
  // Protobuf's JSON leaves zeros out: an edge at 0 is an empty interval's.
  return min && max && *min < *max ? std::optional(MassRange{*min, *max}) : std::nullopt;
}

std::optional<model::LoopParameters> LoopOf(const json& message) {
  if (!message.is_object()) {
    return std::nullopt;
  }
  const auto number = [&message](const char* name) { return Number(message, name).value_or(0); };
  const model::LoopParameters loop{.device_mass = number("device_mass"),
                                   .device_damping = number("device_damping"),
                                   .hand_mass = number("hand_mass"),
                                   .hand_damping = number("hand_damping"),
                                   .hand_stiffness = number("hand_stiffness"),
                                   .period_s = number("period_s"),
                                   .cutoff_hz = number("cutoff_hz"),
                                   .delay_s = number("delay_s"),
                                   .accelerometer_bandwidth_hz = number("accelerometer_bandwidth_hz")};
  return model::Validate(loop) ? std::nullopt : std::optional(loop);
}

using Metadata = std::map<std::string, std::string>;

std::optional<double> Number(const Metadata& metadata, const std::string& key) {
  const auto entry = metadata.find(key);
  if (entry == metadata.end()) {
    return std::nullopt;
  }
  const std::string& text = entry->second;
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

std::optional<MassRange> Range(const Metadata& metadata, const std::string& name) {
  const auto min = Number(metadata, name + "_min");
  const auto max = Number(metadata, name + "_max");
  return min && max && *min < *max ? std::optional(MassRange{*min, *max}) : std::nullopt;
}

}  // namespace

AxisFacts FactsOf(const std::string& axis_state) {
  const json state = json::parse(axis_state, nullptr, false);
  const json& info = Field(state, "info");
  const json& m_width = Field(state, "m_width");
  AxisFacts facts{.loop = LoopOf(Field(info, "loop")),
                  .nominal = Range(m_width, "nominal"),
                  .robust = Range(m_width, "robust"),
                  .admitted = Range(m_width, "admitted"),
                  .required_gain_margin_db = Number(m_width, "required_gain_margin_db"),
                  .simulated = std::nullopt};
  if (const json& simulated = Field(info, "simulated"); simulated.is_boolean()) {
    facts.simulated = simulated.get<bool>();
  }
  return facts;
}

std::vector<MarginsInForce> MarginsOf(const std::vector<record::Event>& events) {
  std::vector<MarginsInForce> margins;
  for (const record::Event& event : events) {
    if (event.kind == record::EventKind::kMassSet || event.kind == record::EventKind::kFilterSet) {
      const Metadata& figures = event.metadata;
      margins.push_back({.tick = event.tick,
                         .mass = Number(figures, "mass"),
                         .gain_db = Number(figures, "gain_margin_db"),
                         .phase_deg = Number(figures, "phase_margin_deg"),
                         .delay_s = Number(figures, "delay_margin_s"),
                         .modulus = Number(figures, "modulus_margin"),
                         .nominal = Range(figures, "nominal"),
                         .robust = Range(figures, "robust"),
                         .admitted = Range(figures, "admitted")});
    }
  }
  std::stable_sort(margins.begin(), margins.end(),
                   [](const auto& a, const auto& b) { return a.tick < b.tick; });
  return margins;
}

const MarginsInForce* InForceAt(const std::vector<MarginsInForce>& margins, uint64_t tick) {
  const auto after =
      std::upper_bound(margins.begin(), margins.end(), tick,
                       [](uint64_t at, const MarginsInForce& margin) { return at < margin.tick; });
  return after == margins.begin() ? nullptr : &*(after - 1);
}

}  // namespace mwidth::cli::session
