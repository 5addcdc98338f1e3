#include "server/config_limits.h"

#include <algorithm>

namespace mwidth::server {
namespace {

constexpr double kLargest = 1e6;
constexpr int kDefaultMaxMissedTicks = 5;

// A quarter of a period: more than an ordinary host needs to compute, less than a drive's link may hide.
constexpr double kDefaultDelayTolerance = 0.25;

// Counts per tick, and share of the velocity limit, from which no hand comes to rest within a tick.
constexpr double kFreezeCounts = 4;
constexpr double kFreezeShare = 0.02;

double DefaultFreezeVelocity(const AxisConfig& axis) {
  return std::max(kFreezeCounts * axis.drive.position_quantum / axis.loop.period_s,
                  kFreezeShare * axis.limits.velocity);
}

}  // namespace

LimitsConfig ReadLimits(ConfigTable& limits) {
  const LimitsConfig read{
      .mass_min = limits.Number("mass_min", {-kLargest, 0}),
      .mass_max = limits.Number("mass_max", {0, kLargest}),
      .force = limits.Number("force", {0, kLargest, true}),
      .force_slew = limits.OptionalNumber("force_slew", {0, kLargest * kLargest, true}),
      .position_min = limits.Number("position_min", {-kLargest, kLargest}),
      .position_max = limits.Number("position_max", {-kLargest, kLargest}),
      .velocity = limits.Number("velocity", {0, kLargest, true}),
      .max_missed_ticks = limits.IntegerOr("max_missed_ticks", {0, 16}, kDefaultMaxMissedTicks),
  };
  if (read.position_min >= read.position_max) {
    limits.Refuse("position_max", "must be above position_min");
  }
  limits.Finish();
  return read;
}

render::WatchConfig ReadWatch(ConfigTable& axis, const AxisConfig& read) {
  const double period_s = read.loop.period_s;
  render::WatchConfig watch;
  watch.delay_limit_s = read.loop.delay_s + kDefaultDelayTolerance * period_s;
  watch.acceleration_limit = read.limits.velocity / period_s;
  watch.freeze_velocity = DefaultFreezeVelocity(read);
  std::optional<ConfigTable> table = axis.OptionalTable("watch");
  if (!table) {
    return watch;
  }
  watch.window_s = table->NumberOr("window_s", {0.1, 10}, watch.window_s);
  const auto part_of_window = [&table, &watch](const char* key, double otherwise) {
    return table->NumberOr(key, {0, watch.window_s}, std::min(otherwise, watch.window_s));
  };
  watch.saturation_s = part_of_window("saturation_s", watch.saturation_s);
  watch.slew_s = part_of_window("slew_s", watch.slew_s);
  watch.gap_s = part_of_window("gap_s", watch.gap_s);
  watch.late_s = part_of_window("late_s", watch.late_s);
  watch.delay_limit_s = read.loop.delay_s + table->NumberOr("delay_tolerance_s", {0, period_s},
                                                            kDefaultDelayTolerance * period_s);
  watch.max_consecutive_overruns = static_cast<uint32_t>(table->IntegerOr(
      "max_consecutive_overruns", {0, 1000}, static_cast<int>(watch.max_consecutive_overruns)));
  watch.acceleration_limit =
      table->NumberOr("acceleration", {0, kLargest * kLargest, true}, watch.acceleration_limit);
  watch.freeze_velocity = table->NumberOr("freeze_velocity", {0, kLargest, true}, watch.freeze_velocity);
  watch.freeze_s = table->NumberOr("freeze_s", {0.01, 10}, watch.freeze_s);
  table->Finish();
  return watch;
}

}  // namespace mwidth::server
