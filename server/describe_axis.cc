#include "server/describe_axis.h"

#include <limits>

namespace mwidth::server {

gate::AxisDescription DescribeAxis(const AxisConfig& config) {
  gate::AxisDescription description;
  description.name = config.name;
  description.kind = config.kind;
  description.loop = config.loop;
  description.mass_min = config.limits.mass_min;
  description.mass_max = config.limits.mass_max;
  description.force_limit = config.limits.force;
  description.force_slew_limit = config.limits.force_slew.value_or(std::numeric_limits<double>::infinity());
  description.required_gain_margin_db = config.required_gain_margin_db;
  description.position_quantum = config.drive.position_quantum;
  description.force_quantum = config.drive.force_quantum;
  description.acceleration_quantum = config.drive.acceleration_quantum;
  description.force_noise_limit = config.force_noise_limit;
  description.hand_envelope = config.hand_envelope;
  description.device_tolerance = config.device_tolerance;
  description.delay_tolerance_s = config.watch.delay_limit_s - config.loop.delay_s;
  return description;
}

std::string RenderingBlockedReason(bool simulated, const render::RealtimeReport& realtime,
                                   bool allow_non_realtime) {
  if (simulated || realtime.realtime || allow_non_realtime) {
    return {};
  }
  return "The host refuses what this loop needs to be on time: " + realtime.message +
         ". Change that (mwidthd doctor helps), or start mwidthd with --allow-non-realtime to accept missed "
         "deadlines on a real drive.";
}

}  // namespace mwidth::server
