#include "server/record/export/bids_motion.h"

#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "server/model/estimator_kind.h"
#include "server/record/export/bids_labels.h"
#include "server/record/export/file_set.h"
#include "server/record/export/session_json.h"
#include "server/record/export/text.h"

namespace mwidth::record {
namespace {

using Json = nlohmann::ordered_json;

// What is written at once, also within a gap of hours.
constexpr size_t kBufferBytes = size_t{1} << 18;

class MotionTable {
 public:
  MotionTable(const std::vector<BidsChannel>& channels, const std::filesystem::path& file)
      : channels_(channels), out_(file) {
    for (size_t i = 0; i < channels.size(); ++i) {
      missing_row_ += i == 0 ? "n/a" : "\tn/a";
    }
    missing_row_ += '\n';
  }

  void Add(const exchange::Sample& sample) {
    if (extent_.samples == 0) {
      extent_.first_tick = sample.tick;
      extent_.first_monotonic_ns = sample.monotonic_ns;
    } else {
      FillGap(sample.tick);
    }
    if (extent_.filters.empty() || extent_.filters.back().second != sample.filter) {
      extent_.filters.emplace_back(sample.tick, sample.filter);
    }
    for (const BidsChannel& channel : channels_) {
      AppendCell(text_, channel, sample, extent_.first_monotonic_ns);
      text_ += '\t';
    }
    text_.back() = '\n';
    WriteWhenFull();
    extent_.last_tick = sample.tick;
    extent_.last_monotonic_ns = sample.monotonic_ns;
    ++extent_.samples;
  }

  MotionExtent Close() {
    out_.Write(text_);
    out_.Close();
    return extent_;
  }

 private:
  void FillGap(uint64_t tick) {
    if (tick <= extent_.last_tick) {
      throw std::runtime_error("tick " + std::to_string(tick) + " comes after tick " +
                               std::to_string(extent_.last_tick) + "; mwidth session verify says more");
    }
    for (uint64_t missing = extent_.last_tick + 1; missing < tick; ++missing) {
      text_ += missing_row_;
      WriteWhenFull();
    }
  }
  void WriteWhenFull() {
    if (text_.size() >= kBufferBytes) {
      out_.Write(text_);
      text_.clear();
    }
  }

  const std::vector<BidsChannel>& channels_;
  TextFile out_;
  std::string missing_row_;
  std::string text_;
  MotionExtent extent_;
};

// BIDS: an object for each filter, with its settings.
Json SoftwareFilters(const MotionExtent& extent) {
  Json json = Json::object();
  for (const auto& [tick, filter] : extent.filters) {
    json["acceleration, from row " + std::to_string(tick - extent.first_tick)] = {
        {"Estimator", model::Name(static_cast<model::EstimatorKind>(filter.estimator))},
        {"CutoffFrequency", filter.cutoff_hz},
        {"CutoffFrequencyUnits", "Hz"}};
  }
  return json;
}

double EffectiveFrequency(const MotionExtent& extent, double nominal_hz) {
  const int64_t duration_ns = extent.last_monotonic_ns - extent.first_monotonic_ns;
  return duration_ns > 0 ? static_cast<double>(extent.last_tick - extent.first_tick) /
                               (1e-9 * static_cast<double>(duration_ns))
                         : nominal_hz;
}

}  // namespace

MotionExtent WriteMotion(SessionReader& reader, const std::vector<BidsChannel>& channels,
                         const std::filesystem::path& file) {
  MotionTable table(channels, file);
  reader.Seek(0);
  for (std::vector<exchange::Sample> samples; reader.Next(samples);) {
    for (const exchange::Sample& sample : samples) {
      table.Add(sample);
    }
  }
  return table.Close();
}

std::string MotionJson(const SessionInfo& info, const std::vector<BidsChannel>& channels,
                       const MotionExtent& extent) {
  std::map<std::string, int> counts;
  for (const BidsChannel& channel : channels) {
    ++counts[channel.type];
  }
  const double frequency_hz = 1 / info.axis.period_s;
  Json json{{"TaskName", info.labels.task},
            {"SamplingFrequency", frequency_hz},
            {"SamplingFrequencyEffective", EffectiveFrequency(extent, frequency_hz)},
            // One period for each row.
            {"RecordingDuration", static_cast<double>(extent.rows()) * info.axis.period_s},
            {"RecordingType", "continuous"},
            {"TrackingSystemName", kTrackingSystem},
            {"MotionChannelCount", channels.size()},
            {"TrackedPointsCount", 1},
            {"MissingValues", "n/a"},
            {"SoftwareVersions", "mwidthd " + info.provenance.software_version},
            {"SoftwareFilters", SoftwareFilters(extent)}};
  for (const char* type :
       {"ACCEL", "ANGACCEL", "GYRO", "JNTANG", "LATENCY", "MAGN", "MISC", "ORNT", "POS", "VEL"}) {
    json[std::string(type) + "ChannelCount"] = counts[type];
  }
  return Indented(json);
}

}  // namespace mwidth::record
