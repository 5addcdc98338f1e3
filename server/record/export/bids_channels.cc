#include "server/record/export/bids_channels.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "server/record/export/session_json.h"
#include "server/record/export/text.h"

namespace mwidth::record {
namespace {

constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;

struct Kind {
  const char* name;
  const char* component;
  const char* type;
  const char* units;
  double scale = 1;
};

// BIDS's VEL is linear, its GYRO a sensor that is not there, so that a joint's velocity is MISC. Units as
// CMIXF-12 writes them.
constexpr std::array<Kind, 5> kLinear{{{"position", "x", "POS", "m"},
                                       {"velocity", "x", "VEL", "m/s"},
                                       {"acceleration", "x", "ACCEL", "m/s^2"},
                                       {"force", "n/a", "MISC", "N"},
                                       {"mass", "n/a", "MISC", "kg"}}};
constexpr std::array<Kind, 5> kRotary{{{"position", "n/a", "JNTANG", "deg", kDegreesPerRadian},
                                       {"velocity", "n/a", "MISC", "deg/s", kDegreesPerRadian},
                                       {"acceleration", "z", "ANGACCEL", "deg/s^2", kDegreesPerRadian},
                                       {"force", "n/a", "MISC", "N.m"},
                                       {"mass", "n/a", "MISC", "kg.m^2"}}};

// What the numbers of a Coded column stand for belongs to what is said of it.
std::string Description(const Column& column) {
  std::string text = column.description;
  for (size_t code = 0; code < column.words.size(); ++code) {
    text += (code == 0 ? ": " : ", ") + std::to_string(code) + ' ' + std::string(column.words[code]);
  }
  return text;
}

BidsChannel ChannelOf(const Column& column, const SessionAxis& axis) {
  const auto& kinds = axis.rotary ? kRotary : kLinear;
  const auto* const kind =
      std::find_if(kinds.begin(), kinds.end(), [&](const Kind& k) { return column.name == k.name; });
  BidsChannel channel{.name = column.name,
                      .component = "n/a",
                      .type = "MISC",
                      .tracked_point = axis.name,
                      .units = column.units == "1" ? "n/a" : column.units,
                      .reference_frame = "n/a",
                      .description = Description(column),
                      .of = column.of};
  if (kind != kinds.end()) {
    // BIDS knows no other force on a joint: its name says what it is.
    channel.name = axis.rotary && column.name == "force" ? "torque" : column.name;
    channel.component = kind->component;
    channel.type = kind->type;
    channel.units = kind->units;
    channel.scale = kind->scale;
    channel.reference_frame = channel.component == "n/a" ? "n/a" : "axis";
  }
  return channel;
}

// Microseconds, rounded down: the form that BIDS gives for LATENCY.
void AppendLatency(std::string& out, int64_t latency_ns) {
  const std::string micros = std::to_string(latency_ns / 1000 % 1'000'000);
  out += std::to_string(latency_ns / 1'000'000'000) + '.' + std::string(6 - micros.size(), '0') + micros;
}

}  // namespace

std::vector<BidsChannel> ChannelsOf(const SessionAxis& axis) {
  std::vector<BidsChannel> channels{{.name = "latency",
                                     .component = "n/a",
                                     .type = "LATENCY",
                                     .tracked_point = "n/a",
                                     .units = "s",
                                     .reference_frame = "n/a",
                                     .description = "When the sample was taken, since the first one"}};
  std::vector<BidsChannel> others;
  for (const Column& column : SampleColumns(axis.rotary)) {
    auto channel = ChannelOf(column, axis);
    const bool quantity = std::any_of(kLinear.begin(), kLinear.end(),
                                      [&](const Kind& kind) { return column.name == kind.name; });
    (quantity ? channels : others).push_back(std::move(channel));
  }
  channels.insert(channels.end(), others.begin(), others.end());
  return channels;
}

std::string ChannelsTsv(const std::vector<BidsChannel>& channels, double sampling_frequency_hz) {
  // The first five are required, in this order.
  std::string text =
      "name\tcomponent\ttype\ttracked_point\tunits\tsampling_frequency\treference_frame\tdescription\n";
  for (const BidsChannel& channel : channels) {
    text += channel.name + '\t' + channel.component + '\t' + channel.type + '\t' +
            TsvCell(channel.tracked_point) + '\t' + channel.units + '\t' + Number(sampling_frequency_hz) +
            '\t' + channel.reference_frame + '\t' + TsvCell(channel.description) + '\n';
  }
  return text;
}

std::string ChannelsJson(const SessionAxis& axis) {
  const std::string where = axis.rotary
                                ? "z is the axis of rotation, positive as the joint angle."
                                : "x is the direction in which the axis moves, positive as its position.";
  nlohmann::ordered_json json;
  json["reference_frame"]["Description"] = "The frame in which components are told";
  json["reference_frame"]["Levels"]["axis"]["Description"] = "The frame of the device's axis \"" + axis.name +
                                                             "\": " + where +
                                                             " How it lies to the body is not recorded.";
  return Indented(json);
}

void AppendCell(std::string& out, const BidsChannel& channel, const exchange::Sample& sample,
                int64_t first_monotonic_ns) {
  if (channel.of == nullptr) {
    AppendLatency(out, sample.monotonic_ns - first_monotonic_ns);
    return;
  }
  const Value value = channel.of(sample);
  if (const double* number = std::get_if<double>(&value)) {
    const double scaled = *number * channel.scale;
    if (std::isfinite(scaled)) {
      AppendNumber(out, scaled);
    } else {
      out += "n/a";
    }
  } else if (const Coded* coded = std::get_if<Coded>(&value)) {
    out += std::to_string(coded->code);
  } else {
    AppendValue(out, value);
  }
}

}  // namespace mwidth::record
