// Who decides whether there may be a force: IDLE -> READY -> RENDERING -> FAULT.
#pragma once

#include <cstdint>
#include <optional>

#include "device/drive.h"
#include "server/exchange/crossing.h"
#include "server/render/accelerometer_watch.h"
#include "server/render/breach.h"
#include "server/render/drive_watch.h"
#include "server/render/encoder_watch.h"
#include "server/render/force_watch.h"
#include "server/render/hand_monitor.h"
#include "server/render/loop_config.h"
#include "server/render/mass_ramp.h"
#include "server/render/observation.h"
#include "server/render/timing_watch.h"

namespace mwidth::render {

/// The time of the ramp to zero when rendering ends in good order: a stop, or a lease that ran out. For the
/// lease, that and the tick that notices stay within the 500 ms that are promised.
inline constexpr double kEndRampS = 0.2;

/// The least time of the ramp to zero before another filter takes over, and of the ramp back afterwards.
inline constexpr double kFilterRampS = 0.2;

/// The state machine of one axis, and the only one that switches its drive on and off. The loop's thread; all
/// Rt.
///
///   IDLE       drive disabled. A start enables it, which may take the drive some ticks: a start that is
///   taken
///              back meanwhile leaves it disabled.
///   READY      drive enabled, zero force. A silent drive is a fault: whether its force is zero cannot be
///              known; so is a broken encoder.
///   RENDERING  the mass ramps to what is set. The only state that watches motion, force and timing:
///              elsewhere there is no force that could make them unsafe, and the arm must be free to be moved
///              back to where it may begin.
///   FAULT      the mass ramps to zero where the estimate is still sound, and is cut at once where it is not;
///              then the drive is disabled. Latched until cleared, and then IDLE.
class Supervisor {
 public:
  /// `history` is what was set before the loop began: a start in it is not obeyed, or a loop that is made
  /// anew would begin to render by itself. An emergency stop in it is obeyed.
  Supervisor(const LoopConfig& config, const exchange::Settings& history, device::Drive& drive) noexcept;

  /// Obeys the settings, watches the motion, and returns the virtual mass of this tick.
  double Step(const exchange::Settings& settings, const Observation& seen) noexcept;
  /// After Step: the force that came out of the mass, and what clamped it.
  void ReportForce(const ForceCommand& force) noexcept;
  /// After Step: whether the drive took the force; true where none was sent.
  void ReportWrite(bool taken) noexcept;
  /// After Step: a force that is no number came out.
  void ReportNotFinite(double value) noexcept;

  /// From now on nothing begins, and what is rendered ramps to zero.
  void BeginStop() noexcept { stopping_ = true; }
  /// True when no force is left that would have to ramp down.
  bool AtRest() const noexcept;
  /// True when no mass is rendered or on its way: the filter may change, and no force will jump.
  bool MassIsZero() const noexcept { return mass_.mass() == 0 && mass_.target() == 0; }
  /// Disables the drive whatever the state; a fault stays.
  void Close() noexcept;

  exchange::State state() const noexcept { return state_; }
  const exchange::FaultRecord& fault() const noexcept { return fault_; }
  bool drive_enabled() const noexcept { return enabled_; }
  double mass() const noexcept { return mass_.mass(); }
  double target_mass() const noexcept { return mass_.target(); }
  /// The epoch that last began, and how many renderings ended.
  uint64_t render_epoch() const noexcept { return render_epoch_; }
  uint64_t renderings_ended() const noexcept { return renderings_ended_; }
  const ForceWatch& force_watch() const noexcept { return force_watch_; }

 private:
  void Obey(const exchange::Settings& settings, const Observation& seen) noexcept;
  /// Switches the drive on; trips where it does not want to, or is on its way for too long.
  bool Enable(int64_t now_ns) noexcept;
  void Begin(const exchange::Settings& settings, const Observation& seen) noexcept;
  /// Ramps to what is set. `running` is the filter that runs: a mass that is admitted for another one waits.
  void Follow(const exchange::Settings& settings, const exchange::Filter& running) noexcept;
  void Clear(uint64_t cleared_fault_number) noexcept;
  void Watch(const Observation& seen) noexcept;
  Breach JudgeHand(const Observation& seen) noexcept;
  void FinishRamp() noexcept;
  void Judge(const Breach& breach) noexcept;
  void Trip(exchange::Fault fault, double value, double limit) noexcept;
  void SwitchOff() noexcept;

  const LoopConfig config_;
  device::Drive& drive_;
  const device::DriveInfo drive_info_;
  MassRamp mass_;
  exchange::State state_ = exchange::State::kIdle;
  exchange::FaultRecord fault_;
  bool enabled_ = false;
  // Since when the drive is on its way to being enabled.
  std::optional<int64_t> arming_since_ns_;
  bool ending_ = false;
  bool stopping_ = false;
  bool changing_filter_ = false;
  uint64_t tick_ = 0;
  // Highest epoch seen; a start is obeyed or forfeited when it is first seen, never kept for later.
  uint64_t epoch_seen_ = 0;
  uint64_t render_epoch_ = 0;
  uint64_t renderings_ended_ = 0;
  uint64_t emergency_stops_seen_ = 0;
  uint64_t cleared_fault_number_ = 0;
  DriveWatch drive_watch_;
  EncoderWatch encoder_watch_;
  AccelerometerWatch accelerometer_watch_;
  ForceWatch force_watch_;
  TimingWatch timing_watch_;
  HandMonitor hand_monitor_;
};

}  // namespace mwidth::render
