// Cuts the samples of a loop into batches of evenly spaced ticks, and accounts for every tick that is absent.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "server/exchange/crossing.h"
#include "server/record/reduction.h"

namespace mwidth::record {

/// How a stream is cut; streams of equal cuts can share their batches.
struct Cut {
  /// Ticks that become one sample; above 0.
  uint32_t decimation = 1;
  Reduction reduction = Reduction::kPick;
  /// Samples of a batch: 1 <= min_batch <= max_batch. With a min_batch of 1 nothing waits for a fuller batch.
  std::size_t min_batch = 1;
  std::size_t max_batch = 100;

  auto operator<=>(const Cut&) const = default;
};

/// Sample i belongs to tick first_tick + i * decimation.
struct Batch {
  uint64_t first_tick = 0;
  uint32_t decimation = 1;
  Reduction reduction = Reduction::kPick;
  /// Ticks since the previous batch that never ran.
  uint64_t missed_ticks_before = 0;
  /// Ticks since the previous batch that ran, and whose samples did not arrive.
  uint64_t dropped_ticks_before = 0;
  std::vector<exchange::Sample> samples;
  /// One a sample with Reduction::kMinMax; otherwise none.
  std::vector<Extremes> extremes;
};

/// Reduces samples and fills batches with what comes out. Absent ticks are counted in ticks of the loop,
/// whatever the decimation:
///
///     absent = missed + dropped = tick - previous tick - 1, missed = growth of Sample::missed_ticks
///
/// where the previous tick is the last sample seen. At a decimation of 1 that is exactly the gap between two
/// batches. Absent ticks always begin a new batch. Ticks before the first sample are not absent.
///
/// Where min_batch is above 1 batches end at fixed ticks, so that batchers of different phases never end
/// theirs together: a batch at the start or behind a gap may be shorter. Pure: one thread at a time.
class Batcher {
 public:
  using Emit = std::function<void(const Batch&)>;

  /// Batches end `phase` samples, 0 to min_batch - 1, before those of a batcher without one. Throws
  /// std::invalid_argument for a cut out of range.
  explicit Batcher(const Cut& cut, std::size_t phase = 0);

  /// Takes the samples that have come together, whose ticks rise strictly from call to call, and hands on
  /// each batch that is complete.
  void Take(std::span<const exchange::Sample> samples, const Emit& emit);
  /// Hands on what waits for a fuller batch: nothing follows soon.
  void Flush(const Emit& emit);

 private:
  void Count(const exchange::Sample& sample);
  void Append(const ReducedSample& reduced);
  bool Complete(std::size_t ticks_at_hand) const;

  const Cut cut_;
  const std::size_t phase_;
  Reducer reducer_;
  // The last sample seen.
  bool started_ = false;
  uint64_t last_tick_ = 0;
  uint64_t last_missed_ticks_ = 0;
  // Absent ticks that no batch has told yet.
  uint64_t missed_ = 0;
  uint64_t dropped_ = 0;
  Batch batch_;
};

}  // namespace mwidth::record
