#include "server/record/session/derived_columns.h"

#include <bit>

#include "server/render/limits.h"

namespace mwidth::record {

DerivedColumns DerivedOf(const exchange::Sample& sample) noexcept {
  return {.position = sample.position,
          .velocity = sample.velocity,
          .acceleration = sample.acceleration,
          .force = sample.force,
          .answered_tick = sample.answered_tick,
          .filter_memory = sample.filter_memory};
}

void SetDerived(const DerivedColumns& derived, exchange::Sample& sample) noexcept {
  sample.position = derived.position;
  sample.velocity = derived.velocity;
  sample.acceleration = derived.acceleration;
  sample.force = derived.force;
  sample.answered_tick = derived.answered_tick;
  sample.filter_memory = derived.filter_memory;
}

bool SameBits(const DerivedColumns& a, const DerivedColumns& b) noexcept {
  using AsBits = std::array<uint64_t, 8>;
  return std::bit_cast<AsBits>(a) == std::bit_cast<AsBits>(b);
}

ColumnRebuilder::ColumnRebuilder(const SessionAxis& axis) noexcept
    : period_s_(axis.period_s),
      position_quantum_(axis.position_quantum),
      force_quantum_(axis.force_quantum),
      acceleration_quantum_(axis.acceleration_quantum) {}

bool ColumnRebuilder::Runs(const exchange::Filter& filter) const noexcept {
  return model::Runs(static_cast<model::EstimatorKind>(filter.estimator), period_s_, filter.cutoff_hz);
}

bool ColumnRebuilder::Begin(const exchange::Sample& first) noexcept {
  if (!Runs(first.filter)) {
    return false;
  }
  filter_ = first.filter;
  estimator_.emplace(period_s_, filter_.cutoff_hz, static_cast<model::EstimatorKind>(filter_.estimator));
  estimator_->Restore({.position = first.position,
                       .velocity = first.velocity,
                       .acceleration = first.acceleration,
                       .low_pass = first.filter_memory,
                       .primed = first.answered_tick != 0});
  answered_tick_ = first.answered_tick;
  return true;
}

std::optional<DerivedColumns> ColumnRebuilder::Follow(const exchange::Sample& sample) noexcept {
  if (sample.filter != filter_) {
    if (!Runs(sample.filter)) {
      return std::nullopt;
    }
    filter_ = sample.filter;
    estimator_ =
        estimator_->ChangedTo(static_cast<model::EstimatorKind>(filter_.estimator), filter_.cutoff_hz);
  }
  if (!sample.position_stale) {
    estimator_->Update(render::PositionOf(sample.position_counts, position_quantum_),
                       sample.tick - answered_tick_, sample.acceleration_counts * acceleration_quantum_);
    answered_tick_ = sample.tick;
  }
  const model::EstimatorMemory memory = estimator_->Memory();
  return DerivedColumns{.position = memory.position,
                        .velocity = memory.velocity,
                        .acceleration = memory.acceleration,
                        .force = sample.force_counts * force_quantum_,
                        .answered_tick = answered_tick_,
                        .filter_memory = memory.low_pass};
}

}  // namespace mwidth::record
