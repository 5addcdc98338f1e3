// Samples as the loop posts them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/record/session/derived_columns.h"
#include "server/record/session/session_info.h"
#include "tests/server/render/axis.h"
#include "tests/support/temporary_folder.h"

namespace mwidth::record {

inline SessionAxis AxisOf(const render::LoopConfig& config, const device::DriveInfo& info) {
  return {.name = "elbow",
          .rotary = true,
          .period_s = config.period_s,
          .position_quantum = info.position_quantum,
          .force_quantum = info.force_quantum,
          .acceleration_quantum = info.acceleration_quantum,
          .force_limit = config.force_limit,
          .force_slew_limit = config.force_slew_limit};
}

/// An arm that swings under a virtual mass; now and then the drive is silent, takes no force, or a deadline
/// is missed, and the filter changes.
class SwingingArm {
 public:
  SwingingArm() : axis_(Config()) { axis_.Start(0.3, 0.2); }

  exchange::Sample Next() {
    const int i = count_++;
    axis_.drive.takes_writes = i % 97 != 5;
    axis_.drive.answers_reads = i % 89 != 7;
    if (i % 1500 == 900) {
      constexpr model::EstimatorKind kKinds[] = {
          model::EstimatorKind::kKalman, model::EstimatorKind::kButterworth,
          model::EstimatorKind::kLateFilteredDifference, model::EstimatorKind::kFilteredDifference};
      axis_.settings.filter = {.estimator = static_cast<uint8_t>(kKinds[i / 1500 % 4]), .cutoff_hz = 10};
      axis_.Post();
    }
    return axis_.Swing(i % 101 == 50 ? 2 : 0);
  }
  std::vector<exchange::Sample> Take(int ticks) {
    std::vector<exchange::Sample> samples;
    for (int i = 0; i < ticks; ++i) {
      samples.push_back(Next());
    }
    return samples;
  }
  SessionAxis axis() const { return AxisOf(axis_.config, axis_.drive.info); }

 private:
  static render::LoopConfig Config() {
    render::LoopConfig config = render::TestConfig();
    config.force_limit = 4;
    config.force_slew_limit = 50;
    config.watch.saturation_s = config.watch.slew_s = config.watch.gap_s = 1;
    return config;
  }

  render::Axis axis_;
  int count_ = 0;
};

inline SessionInfo InfoOf(const SessionAxis& axis) {
  SessionInfo info;
  info.labels = {.subject = "01",
                 .visit = "1",
                 .task = "reach",
                 .run = 2,
                 .operator_name = "who",
                 .metadata = {{"hand", "right"}, {"note", "quotes \" and \xc3\xbc"}}};
  info.axis = axis;
  info.provenance = {.software_version = "0.1.0",
                     .configuration = "[axis]\nname = \"elbow\"\n",
                     .command_line = "--listen 127.0.0.1:0",
                     .axis_state = "{}"};
  info.start_wall_ns = 1'790'000'000'123'456'789;
  info.start_monotonic_ns = 1'000'000'000;
  return info;
}

/// Every field, quantities to the bit.
inline bool SameSample(const exchange::Sample& a, const exchange::Sample& b) {
  return a.tick == b.tick && a.monotonic_ns == b.monotonic_ns && a.position_counts == b.position_counts &&
         a.acceleration_counts == b.acceleration_counts && a.force_counts == b.force_counts &&
         a.state == b.state && a.saturated == b.saturated && a.slew_limited == b.slew_limited &&
         a.position_stale == b.position_stale && a.force_taken == b.force_taken &&
         a.missed_ticks == b.missed_ticks &&
         std::bit_cast<uint64_t>(a.mass) == std::bit_cast<uint64_t>(b.mass) &&
         a.filter.estimator == b.filter.estimator &&
         std::bit_cast<uint64_t>(a.filter.cutoff_hz) == std::bit_cast<uint64_t>(b.filter.cutoff_hz) &&
         SameBits(DerivedOf(a), DerivedOf(b));
}

inline bool SameSamples(const std::vector<exchange::Sample>& a, const std::vector<exchange::Sample>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), SameSample);
}

}  // namespace mwidth::record
