// Proof of what ran: the recorded positions, sent once more through the estimator and the force law, give the
// recorded forces to the last bit.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "server/exchange/crossing.h"
#include "server/model/estimator.h"
#include "server/record/session/session_info.h"

namespace mwidth::record {

/// What is computed again. Counts and flags are compared as numbers, quantities as bits.
enum class ReplayedColumn : uint8_t {
  kPosition,
  kVelocity,
  kAcceleration,
  kForceCounts,
  kForce,
  kSaturated,
  kSlewLimited,
};

/// "position", "force_counts", ..: as exports name the columns.
const char* Name(ReplayedColumn column) noexcept;

struct ReplayDifference {
  uint64_t tick = 0;
  ReplayedColumn column = ReplayedColumn::kPosition;
  double recorded = 0;
  double computed = 0;
};

struct ReplayFigures {
  /// Each is in one of the four below, or all its columns are equal.
  uint64_t samples = 0;
  /// The first one, and the first after each loss: estimator and filter go on from what these recorded, and
  /// only their positions are compared.
  uint64_t begun = 0;
  uint64_t losses = 0;
  /// Motion compared, but not the force: it is limited in its step from a force that only lost samples tell.
  uint64_t force_unknown = 0;
  /// Of a filter that does not exist: nothing compared but the position.
  uint64_t filter_unknown = 0;
  /// In one column or several.
  uint64_t different = 0;
  /// The first Replay::kMaxDifferences, in the order of ticks and columns.
  std::vector<ReplayDifference> first_differences;

  /// Every column of these was computed from counts, and compared.
  uint64_t compared() const noexcept { return samples - begun - force_unknown - filter_unknown; }
  /// No difference, and at least one sample that was wholly compared.
  bool proves() const noexcept { return different == 0 && compared() > 0; }
};

/// Does what render::Tick did, from tick, missed_ticks, state, position_counts, acceleration_counts,
/// position_stale, filter, mass and force_taken of the samples alone; of what it is to compute it takes
/// nothing, except where a row of samples begins. Where the drive did not take a force, the next step is
/// limited from the force before; in IDLE the drive is disabled and no force acts.
///
/// A position, or a force, that was altered in a single bit is found. So is a mass, as soon as a count of
/// force depends on it: what the mass should have been is not in a session, the file's checksums guard it.
/// One thread.
class Replay {
 public:
  static constexpr std::size_t kMaxDifferences = 20;

  /// Throws std::invalid_argument where `axis` cannot be that of a loop.
  explicit Replay(const SessionAxis& axis);

  /// The next sample, in the order of ticks.
  void Add(const exchange::Sample& sample);

  const ReplayFigures& figures() const noexcept { return figures_; }

 private:
  void BeginWith(const exchange::Sample& sample);
  void Follow(const exchange::Sample& sample);
  void CompareMotion(const exchange::Sample& sample);
  void CompareForce(const exchange::Sample& sample);
  void Compare(uint64_t tick, ReplayedColumn column, double recorded, double computed);

  SessionAxis axis_;
  int32_t largest_force_counts_;
  int64_t largest_step_counts_;
  // None before a row of samples begins.
  std::optional<model::AccelerationEstimator> estimator_;
  exchange::Filter filter_;
  uint64_t answered_tick_ = 0;
  // The last force that the drive took; none where it is not known.
  std::optional<int32_t> acting_counts_;
  uint64_t last_tick_ = 0;
  uint64_t missed_ticks_ = 0;
  bool differs_ = false;
  ReplayFigures figures_;
};

}  // namespace mwidth::record
