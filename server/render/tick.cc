#include "server/render/tick.h"

#include <cmath>

#include "server/render/force_law.h"

namespace mwidth::render {
namespace {

// What was set before, taken by a loop before this one or not.
exchange::Settings TakeHistory(exchange::Crossing& crossing) noexcept {
  exchange::Settings newest;
  crossing.settings.Take(newest);
  return crossing.settings.Held();
}

}  // namespace

Tick::Tick(const LoopConfig& config, device::Drive& drive, exchange::Crossing& crossing) noexcept
    : drive_(drive),
      crossing_(crossing),
      info_(drive.Info()),
      largest_force_counts_(LargestForceCounts(config.force_limit, info_.force_quantum)),
      largest_step_counts_(LargestStepCounts(config.force_slew_limit, config.period_s, info_.force_quantum,
                                             largest_force_counts_)),
      configured_filter_{.estimator = static_cast<uint8_t>(config.estimator), .cutoff_hz = config.cutoff_hz},
      period_s_(config.period_s),
      settings_(TakeHistory(crossing)),
      filter_(configured_filter_),
      estimator_(config.period_s, config.cutoff_hz, config.estimator),
      supervisor_(config, settings_, drive),
      counter_(info_.position_bits) {}

void Tick::TakeSettings() noexcept {
  crossing_.settings.Take(settings_);
  if (settings_.filter.cutoff_hz == 0) {
    settings_.filter = configured_filter_;
  }
}

void Tick::Run(uint64_t tick, int64_t now_ns, uint64_t missed_ticks) noexcept {
  missed_ticks_ += missed_ticks;
  const device::Reading reading = drive_.Read(tick);
  // After the read, which may wait for the drive: an emergency stop posted meanwhile counts in this tick.
  TakeSettings();
  if (reading.ok) {
    Follow(tick, reading);
  }
  const double mass = supervisor_.Step(settings_, {.tick = tick,
                                                   .monotonic_ns = now_ns,
                                                   .missed_ticks = missed_ticks,
                                                   .fresh = reading.ok,
                                                   .position_counts = position_counts_,
                                                   .answer_periods = answer_periods_,
                                                   .trouble = reading.trouble,
                                                   .trouble_code = reading.trouble_code,
                                                   .position = position_,
                                                   .sensed_acceleration = sensed_acceleration_,
                                                   .velocity = estimator_.velocity(),
                                                   .acceleration = estimator_.acceleration(),
                                                   .force = acting_counts_ * info_.force_quantum,
                                                   .filter = filter_,
                                                   .loop_delay_ns = loop_delay_ns_});
  Command(mass);
  PostSample(tick, now_ns, !reading.ok);
  FollowFilter();
  PostStatus(tick, now_ns);
}

void Tick::Follow(uint64_t tick, const device::Reading& reading) noexcept {
  position_counts_ = counter_.Follow(reading.position_counts);
  position_ = PositionOf(position_counts_, info_.position_quantum);
  // Missed and silent ticks are one gap to the estimator, which bridges it: a held position would read as a
  // jump.
  answer_periods_ = tick - answered_tick_;
  acceleration_counts_ = reading.acceleration_counts;
  sensed_acceleration_ = acceleration_counts_ * info_.acceleration_quantum;
  estimator_.Update(position_, answer_periods_, sensed_acceleration_);
  answered_tick_ = tick;
}

void Tick::FollowFilter() noexcept {
  const auto estimator = static_cast<model::EstimatorKind>(settings_.filter.estimator);
  if (settings_.filter != filter_ && supervisor_.MassIsZero() &&
      Runs(estimator, period_s_, settings_.filter.cutoff_hz, info_)) {
    filter_ = settings_.filter;
    estimator_ = estimator_.ChangedTo(estimator, filter_.cutoff_hz);
  }
}

ForceCommand Tick::ForceAt(double mass) noexcept {
  if (mass == 0) {
    return {};
  }
  const double force = VirtualForce(mass, estimator_.acceleration());
  if (!std::isfinite(force)) {
    supervisor_.ReportNotFinite(force);
    return {};
  }
  return LimitStep(LimitForce(force, info_.force_quantum, largest_force_counts_), acting_counts_,
                   largest_step_counts_);
}

void Tick::Command(double mass) noexcept {
  force_ = ForceAt(mass);
  supervisor_.ReportForce(force_);
  const bool taken = !supervisor_.drive_enabled() || drive_.Write(force_.counts);
  supervisor_.ReportWrite(taken);
  force_taken_ = taken && supervisor_.drive_enabled();
  if (!supervisor_.drive_enabled()) {
    force_ = {};  // The last answer that was missing came in this tick, and the force was taken away again.
    acting_counts_ = 0;
  } else if (taken) {
    acting_counts_ = force_.counts;
  }
}

void Tick::PostSample(uint64_t tick, int64_t now_ns, bool stale) noexcept {
  crossing_.samples.Push({.tick = tick,
                          .monotonic_ns = now_ns,
                          .position_counts = position_counts_,
                          .acceleration_counts = acceleration_counts_,
                          .force_counts = force_.counts,
                          .state = supervisor_.state(),
                          .saturated = force_.saturated,
                          .slew_limited = force_.slew_limited,
                          .position_stale = stale,
                          .force_taken = force_taken_,
                          .missed_ticks = missed_ticks_,
                          .position = position_,
                          .velocity = estimator_.velocity(),
                          .acceleration = estimator_.acceleration(),
                          .force = force_.counts * info_.force_quantum,
                          .mass = supervisor_.mass(),
                          .filter = filter_,
                          .answered_tick = answered_tick_,
                          .filter_memory = estimator_.Memory().low_pass});
}

void Tick::PostStatus(uint64_t tick, int64_t now_ns) noexcept {
  last_tick_ = tick;
  last_ns_ = now_ns;
  crossing_.status.Post({.settings_sequence = settings_.sequence,
                         .tick = tick,
                         .monotonic_ns = now_ns,
                         .state = supervisor_.state(),
                         .fault = supervisor_.fault(),
                         .render_epoch = supervisor_.render_epoch(),
                         .renderings_ended = supervisor_.renderings_ended(),
                         .position = position_,
                         .velocity = estimator_.velocity(),
                         .force = force_.counts * info_.force_quantum,
                         .mass = supervisor_.mass(),
                         .target_mass = supervisor_.target_mass(),
                         .filter = filter_,
                         .missed_ticks = missed_ticks_,
                         .saturated_ticks = supervisor_.force_watch().saturated_ticks(),
                         .slew_limited_ticks = supervisor_.force_watch().slew_limited_ticks()});
}

void Tick::Close() noexcept {
  supervisor_.Close();
  force_ = {};
  PostStatus(last_tick_, last_ns_);
}

}  // namespace mwidth::render
