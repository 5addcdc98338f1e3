#include "server/render/supervisor.h"

#include <algorithm>
#include <cmath>

#include "server/render/motion_limits.h"

namespace mwidth::render {

using exchange::Fault;
using exchange::Settings;
using exchange::State;

namespace {

// Whether the mass may ramp to zero, because the acceleration that it multiplies is still true.
bool LeavesEstimateSound(Fault fault) noexcept {
  switch (fault) {
    case Fault::kPositionLimit:
    case Fault::kVelocityLimit:
    case Fault::kForceSaturation:
    case Fault::kForceSlew:
    case Fault::kLoopDelay:
    case Fault::kPositionGaps:
      return true;
    case Fault::kNone:
    case Fault::kEmergencyStop:
    case Fault::kDriveSilent:
    case Fault::kNotFinite:
    case Fault::kOverrun:
    case Fault::kRepeatedOverrun:
    case Fault::kDriveRefused:
    case Fault::kNoDriveWatchdog:
    case Fault::kForeignTraffic:
    case Fault::kDriveError:
    case Fault::kEncoderJump:
    case Fault::kEncoderFreeze:
    case Fault::kAccelerometer:
    // What grows goes on growing through a ramp.
    case Fault::kGrowingOscillation:
    case Fault::kEnergyExcess:
      return false;
  }
  return false;
}

}  // namespace

Supervisor::Supervisor(const LoopConfig& config, const Settings& history, device::Drive& drive) noexcept
    : config_(config),
      drive_(drive),
      drive_info_(drive.Info()),
      mass_(config.period_s),
      epoch_seen_(history.render_epoch),
      drive_watch_(config),
      encoder_watch_(config, drive_info_.position_quantum),
      accelerometer_watch_(config, drive_info_),
      force_watch_(config),
      timing_watch_(config),
      hand_monitor_(config.hand_monitor, config.period_s, config.force_limit) {}

double Supervisor::Step(const Settings& settings, const Observation& seen) noexcept {
  tick_ = seen.tick;
  // Missed ticks belong to the ramp that was running: its end must not be late because the host was.
  mass_.Advance(seen.missed_ticks);
  cleared_fault_number_ = settings.cleared_fault_number;
  if (settings.emergency_stops > emergency_stops_seen_) {
    emergency_stops_seen_ = settings.emergency_stops;
    Trip(Fault::kEmergencyStop, static_cast<double>(settings.emergency_stops), 0);
  }
  Obey(settings, seen);
  Watch(seen);
  mass_.Advance(1);
  FinishRamp();
  return mass_.mass();
}

void Supervisor::Obey(const Settings& settings, const Observation& seen) noexcept {
  const bool wanted = settings.rendering && settings.lease_deadline_ns > seen.monotonic_ns && !stopping_;
  if (state_ == State::kRendering && ending_) {
    return;  // What is asked for now is answered in READY.
  }
  const bool new_epoch = settings.render_epoch > epoch_seen_;
  epoch_seen_ = std::max(epoch_seen_, settings.render_epoch);
  switch (state_) {
    case State::kIdle:
    case State::kReady:
      if (wanted && (new_epoch || arming_since_ns_)) {
        Begin(settings, seen);
      } else if (arming_since_ns_) {
        SwitchOff();  // The start was taken back before the drive was there.
      }
      break;
    case State::kRendering:
      if (wanted) {
        render_epoch_ = epoch_seen_;
        Follow(settings, seen.filter);
      } else {
        ending_ = true;
        mass_.SetTarget(0, kEndRampS);
      }
      break;
    case State::kFault:
      Clear(settings.cleared_fault_number);
      break;
  }
}

bool Supervisor::Enable(int64_t now_ns) noexcept {
  switch (drive_.Enable()) {
    case device::Enabling::kEnabled:
      arming_since_ns_.reset();
      return true;
    case device::Enabling::kPending:
      arming_since_ns_ = arming_since_ns_.value_or(now_ns);
      if (static_cast<double>(now_ns - *arming_since_ns_) > config_.arming_patience_s * 1e9) {
        Trip(Fault::kDriveRefused, 0, 0);
      }
      break;
    case device::Enabling::kRefused:
      Trip(Fault::kDriveRefused, 0, 0);
      break;
    case device::Enabling::kSilent:
      Trip(Fault::kDriveSilent, 1, 0);
      break;
    case device::Enabling::kNoWatchdog:
      Trip(Fault::kNoDriveWatchdog, 0, 0);
      break;
    case device::Enabling::kForeignTraffic:
      Trip(Fault::kForeignTraffic, 0, 0);
      break;
  }
  return false;
}

void Supervisor::Begin(const Settings& settings, const Observation& seen) noexcept {
  if (!enabled_ && !Enable(seen.monotonic_ns)) {
    return;
  }
  enabled_ = true;
  ending_ = false;
  changing_filter_ = false;
  state_ = State::kRendering;
  render_epoch_ = settings.render_epoch;
  drive_watch_.Begin();
  force_watch_.Begin();
  timing_watch_.Begin();
  hand_monitor_.Forget();
  Follow(settings, seen.filter);
}

void Supervisor::Follow(const Settings& settings, const exchange::Filter& running) noexcept {
  // The gate lets no such mass through. If one comes all the same, nothing that was certified holds any more.
  const auto estimator = static_cast<model::EstimatorKind>(settings.filter.estimator);
  if (!std::isfinite(settings.mass)) {
    Trip(Fault::kNotFinite, settings.mass, 0);
  } else if (!Runs(estimator, config_.period_s, settings.filter.cutoff_hz, drive_info_)) {
    Trip(Fault::kNotFinite, settings.filter.cutoff_hz, 0);
  } else if (settings.filter != running) {
    changing_filter_ = true;
    if (mass_.target() != 0) {
      mass_.SetTarget(0, kFilterRampS);
    }
  } else {
    if (settings.mass != mass_.target()) {
      mass_.SetTarget(settings.mass,
                      changing_filter_ ? std::max(settings.ramp_s, kFilterRampS) : settings.ramp_s);
    }
    changing_filter_ = false;
    hand_monitor_.SetCriticalHz(settings.critical_hz);
  }
}

void Supervisor::Clear(uint64_t cleared_fault_number) noexcept {
  if (!enabled_ && cleared_fault_number >= fault_.number) {
    fault_ = {.number = fault_.number};
    state_ = State::kIdle;
  }
}

void Supervisor::Watch(const Observation& seen) noexcept {
  drive_watch_.Read(seen.fresh, seen.missed_ticks);
  timing_watch_.Wake(seen.missed_ticks, seen.loop_delay_ns);
  force_watch_.Hold(seen.missed_ticks);
  if (seen.fresh) {
    encoder_watch_.Follow(seen.position_counts, seen.answer_periods);
    accelerometer_watch_.Follow(seen.velocity, seen.sensed_acceleration, seen.answer_periods);
  }
  // The cause before what follows from it: an encoder that jumps also leaves the limits.
  if (enabled_) {
    Judge(JudgeTrouble(seen));
  }
  if (enabled_) {
    Judge(drive_watch_.JudgeSilence());
  }
  if (enabled_ && state_ != State::kReady) {
    Judge(timing_watch_.JudgeOverrun());
    Judge(JudgeFinite(seen));
  }
  if (enabled_) {
    Judge(encoder_watch_.Judge());
    if (model::IsAccelerometer(static_cast<model::EstimatorKind>(seen.filter.estimator))) {
      Judge(accelerometer_watch_.Judge());
    }
  }
  if (state_ == State::kRendering) {
    Judge(JudgeHand(seen));
  }
  for (const Breach& breach : {JudgeLimits(seen, config_), force_watch_.Judge(), drive_watch_.JudgeGaps(),
                               timing_watch_.JudgeDelay()}) {
    if (state_ == State::kRendering) {
      Judge(breach);
    }
  }
}

Breach Supervisor::JudgeHand(const Observation& seen) noexcept {
  if (!seen.fresh) {
    return {};
  }
  const HandVerdict verdict = hand_monitor_.Step(
      {.velocity = seen.velocity, .force = seen.force, .mass = mass_.mass(), .periods = seen.answer_periods});
  switch (verdict.kind) {
    case HandVerdict::Kind::kCertified:
      break;
    case HandVerdict::Kind::kGrowingOscillation:
      return {Fault::kGrowingOscillation, verdict.value, verdict.limit};
    case HandVerdict::Kind::kEnergyExcess:
      return {Fault::kEnergyExcess, verdict.value, verdict.limit};
  }
  return {};
}

void Supervisor::ReportForce(const ForceCommand& force) noexcept {
  force_watch_.Follow(force);
  if (state_ == State::kRendering) {
    Judge(force_watch_.Judge());
  }
}

void Supervisor::ReportWrite(bool taken) noexcept {
  drive_watch_.Wrote(taken);
  if (enabled_) {
    Judge(drive_watch_.JudgeSilence());
  }
  if (state_ == State::kRendering) {
    Judge(drive_watch_.JudgeGaps());
  }
}

void Supervisor::ReportNotFinite(double value) noexcept { Trip(Fault::kNotFinite, value, 0); }

void Supervisor::FinishRamp() noexcept {
  if (!mass_.arrived()) {
    return;
  }
  if (state_ == State::kRendering && ending_) {
    ++renderings_ended_;
    state_ = State::kReady;
  } else if (state_ == State::kFault && enabled_) {
    SwitchOff();
  }
}

void Supervisor::Judge(const Breach& breach) noexcept {
  if (breach.fault != Fault::kNone) {
    Trip(breach.fault, breach.value, breach.limit);
  }
}

void Supervisor::Trip(Fault fault, double value, double limit) noexcept {
  if (!LeavesEstimateSound(fault)) {
    mass_.Cut();
    SwitchOff();
  } else if (state_ != State::kFault) {
    mass_.SetTarget(0, config_.fault_ramp_s);
  }
  // The first fault is the cause and stays, except that an emergency stop must be seen, and cleared, for
  // itself.
  if (state_ == State::kFault && fault != Fault::kEmergencyStop) {
    return;
  }
  if (state_ == State::kRendering) {
    ++renderings_ended_;
  }
  state_ = State::kFault;
  // Above whatever was cleared so far, or a fault in a loop that is made anew would be cleared before it was
  // seen.
  const uint64_t number = std::max(fault_.number, cleared_fault_number_) + 1;
  fault_ = {.fault = fault, .number = number, .tick = tick_, .value = value, .limit = limit};
}

void Supervisor::SwitchOff() noexcept {
  // Both, and whatever we believe its state to be: a drive that is slow to disable still gets its zero.
  if (enabled_) {
    drive_.Write(0);
  }
  drive_.Disable();
  enabled_ = false;
  arming_since_ns_.reset();
}

bool Supervisor::AtRest() const noexcept {
  return state_ != State::kRendering && (state_ != State::kFault || !enabled_);
}

void Supervisor::Close() noexcept {
  mass_.Cut();
  SwitchOff();
  if (state_ == State::kRendering) {
    ++renderings_ended_;
  }
  if (state_ != State::kFault) {
    state_ = State::kIdle;
  }
}

}  // namespace mwidth::render
