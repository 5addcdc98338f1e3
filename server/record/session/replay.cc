#include "server/record/session/replay.h"

#include <bit>
#include <cmath>
#include <stdexcept>
#include <string>

#include "server/render/force_law.h"
#include "server/render/limits.h"

namespace mwidth::record {
namespace {

void RequirePositive(double value, const char* name) {
  if (!(value > 0) || !std::isfinite(value)) {
    throw std::invalid_argument("the session's axis has a " + std::string(name) + " of " +
                                std::to_string(value) + ", which no loop has");
  }
}

SessionAxis Checked(const SessionAxis& axis) {
  RequirePositive(axis.period_s, "period");
  RequirePositive(axis.position_quantum, "position quantum");
  RequirePositive(axis.force_quantum, "force quantum");
  if (!(axis.force_limit >= 0) || !(axis.force_slew_limit >= 0)) {
    throw std::invalid_argument("the session's axis has a force limit that no loop has");
  }
  return axis;
}

model::EstimatorKind KindOf(const exchange::Filter& filter) noexcept {
  return static_cast<model::EstimatorKind>(filter.estimator);
}

}  // namespace

const char* Name(ReplayedColumn column) noexcept {
  switch (column) {
    case ReplayedColumn::kPosition:
      return "position";
    case ReplayedColumn::kVelocity:
      return "velocity";
    case ReplayedColumn::kAcceleration:
      return "acceleration";
    case ReplayedColumn::kForceCounts:
      return "force_counts";
    case ReplayedColumn::kForce:
      return "force";
    case ReplayedColumn::kSaturated:
      return "saturated";
    case ReplayedColumn::kSlewLimited:
      return "slew_limited";
  }
  return "unknown";
}

Replay::Replay(const SessionAxis& axis)
    : axis_(Checked(axis)),
      largest_force_counts_(render::LargestForceCounts(axis.force_limit, axis.force_quantum)),
      largest_step_counts_(render::LargestStepCounts(axis.force_slew_limit, axis.period_s, axis.force_quantum,
                                                     largest_force_counts_)) {}

void Replay::Add(const exchange::Sample& sample) {
  ++figures_.samples;
  differs_ = false;
  const bool first = figures_.samples == 1;
  const bool lost = !first && sample.tick - last_tick_ != 1 + sample.missed_ticks - missed_ticks_;
  if (lost) {
    ++figures_.losses;
    estimator_.reset();
    acting_counts_.reset();
  }
  Compare(sample.tick, ReplayedColumn::kPosition, sample.position,
          render::PositionOf(sample.position_counts, axis_.position_quantum));
  if (!model::Runs(KindOf(sample.filter), axis_.period_s, sample.filter.cutoff_hz)) {
    ++figures_.filter_unknown;
    estimator_.reset();
  } else if (!estimator_) {
    ++figures_.begun;
    BeginWith(sample);
  } else {
    Follow(sample);
    CompareMotion(sample);
    CompareForce(sample);
  }
  if (sample.force_taken) {
    acting_counts_ = sample.force_counts;
  } else if (sample.state == exchange::State::kIdle) {
    acting_counts_ = 0;
  }
  last_tick_ = sample.tick;
  missed_ticks_ = sample.missed_ticks;
  figures_.different += differs_ ? 1 : 0;
}

void Replay::BeginWith(const exchange::Sample& sample) {
  filter_ = sample.filter;
  answered_tick_ = sample.answered_tick;
  estimator_.emplace(axis_.period_s, filter_.cutoff_hz, KindOf(filter_));
  estimator_->Restore({.position = sample.position,
                       .velocity = sample.velocity,
                       .acceleration = sample.acceleration,
                       .low_pass = sample.filter_memory,
                       .primed = sample.answered_tick != 0});
}

void Replay::Follow(const exchange::Sample& sample) {
  if (sample.filter != filter_) {
    filter_ = sample.filter;
    estimator_ = estimator_->ChangedTo(KindOf(filter_), filter_.cutoff_hz);
  }
  if (!sample.position_stale) {
    estimator_->Update(render::PositionOf(sample.position_counts, axis_.position_quantum),
                       sample.tick - answered_tick_, sample.acceleration_counts * axis_.acceleration_quantum);
    answered_tick_ = sample.tick;
  }
}

void Replay::CompareMotion(const exchange::Sample& sample) {
  Compare(sample.tick, ReplayedColumn::kVelocity, sample.velocity, estimator_->velocity());
  Compare(sample.tick, ReplayedColumn::kAcceleration, sample.acceleration, estimator_->acceleration());
}

void Replay::CompareForce(const exchange::Sample& sample) {
  // A step as large as the whole range of forces is no limit, wherever it starts.
  const bool any_step = largest_step_counts_ >= 2 * int64_t{largest_force_counts_};
  render::ForceCommand force;
  if (sample.mass != 0) {
    const double wanted = render::VirtualForce(sample.mass, estimator_->acceleration());
    if (!acting_counts_ && !any_step) {
      ++figures_.force_unknown;
      return;
    }
    // Of a force that is no number a loop makes a fault, whose mass is zero.
    if (std::isfinite(wanted)) {
      force = render::LimitStep(render::LimitForce(wanted, axis_.force_quantum, largest_force_counts_),
                                acting_counts_.value_or(0), largest_step_counts_);
    }
  }
  Compare(sample.tick, ReplayedColumn::kForceCounts, sample.force_counts, force.counts);
  Compare(sample.tick, ReplayedColumn::kForce, sample.force, force.counts * axis_.force_quantum);
  Compare(sample.tick, ReplayedColumn::kSaturated, sample.saturated ? 1 : 0, force.saturated ? 1 : 0);
  Compare(sample.tick, ReplayedColumn::kSlewLimited, sample.slew_limited ? 1 : 0, force.slew_limited ? 1 : 0);
}

void Replay::Compare(uint64_t tick, ReplayedColumn column, double recorded, double computed) {
  if (std::bit_cast<uint64_t>(recorded) == std::bit_cast<uint64_t>(computed)) {
    return;
  }
  differs_ = true;
  if (figures_.first_differences.size() < kMaxDifferences) {
    figures_.first_differences.push_back(
        {.tick = tick, .column = column, .recorded = recorded, .computed = computed});
  }
}

}  // namespace mwidth::record
