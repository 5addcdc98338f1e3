// What follows from a session's integers, computed as the loop computed it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "server/exchange/crossing.h"
#include "server/model/estimator.h"
#include "server/record/session/session_info.h"

namespace mwidth::record {

/// The columns of a sample that follow from its integers, its filter and the sample before. Without padding:
/// two are the same where their bytes are.
struct DerivedColumns {
  double position = 0;
  double velocity = 0;
  double acceleration = 0;
  double force = 0;
  uint64_t answered_tick = 0;
  std::array<double, 3> filter_memory{};
};
static_assert(sizeof(DerivedColumns) == 8 * sizeof(double));

DerivedColumns DerivedOf(const exchange::Sample& sample) noexcept;
void SetDerived(const DerivedColumns& derived, exchange::Sample& sample) noexcept;
/// To the bit: 0 is not -0, and a NaN is itself.
bool SameBits(const DerivedColumns& a, const DerivedColumns& b) noexcept;

/// Goes through samples of which none that ran is absent and computes their derived columns by the arithmetic
/// of render::Tick, where it is documented. One thread.
class ColumnRebuilder {
 public:
  explicit ColumnRebuilder(const SessionAxis& axis) noexcept;

  /// Takes up `first` with its derived columns, which are believed. False where they cannot lead to others:
  /// no estimator runs with its filter.
  bool Begin(const exchange::Sample& first) noexcept;
  /// The derived columns of the next sample, of which those it has are not looked at. Nothing where its
  /// filter cannot run. Precondition: Begin and each Follow since gave something.
  std::optional<DerivedColumns> Follow(const exchange::Sample& sample) noexcept;

 private:
  bool Runs(const exchange::Filter& filter) const noexcept;

  double period_s_;
  double position_quantum_;
  double force_quantum_;
  double acceleration_quantum_;
  exchange::Filter filter_{};
  std::optional<model::AccelerationEstimator> estimator_;
  uint64_t answered_tick_ = 0;
};

}  // namespace mwidth::record
