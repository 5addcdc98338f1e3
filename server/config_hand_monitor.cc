#include "server/config_hand_monitor.h"

#include <optional>

namespace mwidth::server {

render::HandMonitorConfig ReadHandMonitor(ConfigTable& axis, const AxisConfig& read) {
  render::HandMonitorConfig monitor;
  monitor.device_mass =
      read.device_tolerance ? read.device_tolerance->device_mass.min : read.loop.device_mass;
  monitor.device_damping =
      read.device_tolerance ? read.device_tolerance->device_damping.min : read.loop.device_damping;
  // Not the released hand's: without a spring to swing on, no damping is needed to take out what the force
  // puts in.
  monitor.least_damping = monitor.device_damping + (read.hand_envelope ? read.hand_envelope->hand_damping.min
                                                                       : read.loop.hand_damping);

  if (std::optional<ConfigTable> table = axis.OptionalTable("hand_monitor")) {
    monitor.enabled = table->BooleanOr("enabled", monitor.enabled);
    monitor.min_swing = table->NumberOr("min_swing", {0.01, 1}, monitor.min_swing);
    monitor.min_growth = table->NumberOr("min_growth", {1, 2}, monitor.min_growth);
    monitor.max_unexplained = table->NumberOr("max_unexplained", {0, 0.1}, monitor.max_unexplained);
    monitor.max_push = table->NumberOr("max_push", {0, 1}, monitor.max_push);
    monitor.max_energy_ratio = table->NumberOr("max_energy_ratio", {1, 10}, monitor.max_energy_ratio);
    monitor.energy_swing = table->NumberOr("energy_swing", {0.05, 2}, monitor.energy_swing);
    table->Finish();
  }
  return monitor;
}

}  // namespace mwidth::server
