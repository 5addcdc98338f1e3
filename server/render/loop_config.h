// What a loop is told before it starts.
#pragma once

#include <cstdint>
#include <limits>

#include "device/drive.h"
#include "server/model/estimator_kind.h"
#include "server/render/hand_monitor_config.h"
#include "server/render/watch_config.h"

namespace mwidth::render {

/// What the loop asks of the host's scheduler.
struct RealtimeConfig {
  /// SCHED_FIFO priority, 1 to 99; 0 leaves the thread to the ordinary scheduler. Below the kernel's own
  /// threads for the interrupts of the drive's link (50 on PREEMPT_RT), the loop would wait for itself: stay
  /// above 50.
  int priority = 80;
  /// The CPU to stay on; negative leaves it to the host.
  int cpu = -1;
  /// True leaves the CPUs the idle states from which they wake slowly; so does a priority of 0.
  bool allow_deep_idle = false;
};

/// One axis. Linear: kg, m, N; rotary: kg m^2, rad, N m. There is no default for what the motor and the
/// person beside it decide: a config without limits is refused.
struct LoopConfig {
  /// Sample period T, 1e-4 to 1e-2 s.
  double period_s = 1e-3;
  /// Filter of the acceleration until another is asked for: what Runs allows.
  model::EstimatorKind estimator = model::EstimatorKind::kFilteredDifference;
  double cutoff_hz = 10;

  /// Largest force that is ever commanded, either sign; above 0.
  double force_limit = 0;
  /// Largest change of the commanded force per second, at least a force count per period; infinite: any. On
  /// its way to zero at the end of a rendering the force obeys it too, but is zero where the mass is.
  double force_slew_limit = std::numeric_limits<double>::infinity();
  /// Where rendering is allowed; a position outside is a fault.
  double position_min = 0;
  double position_max = 0;
  /// Largest speed while rendering, either sign; above 0.
  double velocity_limit = 0;
  /// Ticks that may be skipped at once; more is a fault. At most 16: the force of the last tick acts
  /// meanwhile.
  uint32_t max_missed_ticks = 5;
  /// How long a fault that leaves the estimate sound takes to bring the mass to zero, 0 to 0.05 s.
  double fault_ramp_s = 0.05;
  /// How long a drive may take to be enabled, 0 to 0.9 s: a request to render waits for 1 s.
  double arming_patience_s = 0.8;

  WatchConfig watch;
  HandMonitorConfig hand_monitor;
  RealtimeConfig realtime;
};

/// True where a loop of this period runs `estimator` at `cutoff_hz` with this drive: what model::Runs allows,
/// and an accelerometer only where there is one. Any thread. Rt.
bool Runs(model::EstimatorKind estimator, double period_s, double cutoff_hz,
          const device::DriveInfo& drive) noexcept;

/// `config`, if it can run with a drive of these properties. Throws std::invalid_argument, with the field and
/// what is allowed, where it is out of range.
const LoopConfig& Checked(const LoopConfig& config, const device::DriveInfo& drive);

}  // namespace mwidth::render
