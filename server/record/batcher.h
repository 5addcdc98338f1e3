// Cuts a stream of samples into batches of evenly spaced ticks, and accounts for every tick that is absent.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "server/exchange/crossing.h"

namespace mwidth::record {

/// Sample i belongs to tick first_tick + i * decimation.
struct Batch {
  uint64_t first_tick = 0;
  uint32_t decimation = 1;
  /// Ticks since the previous batch that never ran.
  uint64_t missed_ticks_before = 0;
  /// Ticks since the previous batch that ran, and whose samples did not arrive.
  uint64_t dropped_ticks_before = 0;
  std::vector<exchange::Sample> samples;
};

/// Selects the ticks that are multiples of `decimation` (so that all streams of one decimation agree on them)
/// and fills batches with them. Absent ticks are counted in ticks of the loop, whatever the decimation:
///
///     absent = missed + dropped = tick - previous tick - 1, missed = growth of Sample::missed_ticks
///
/// where the previous tick is the last sample seen, selected or not. At a decimation of 1 that is exactly the
/// gap between two batches. Absent ticks always begin a new batch. Ticks before the first sample are not
/// absent, and those before `first_tick` are passed over. Pure: one thread at a time.
class Batcher {
 public:
  /// `decimation` and `max_batch` are above 0; throws std::invalid_argument otherwise.
  Batcher(uint32_t decimation, std::size_t max_batch, uint64_t first_tick = 0);

  /// Appends from the front of `samples`, whose ticks rise strictly from call to call, to `batch`, and
  /// returns how many it used up, those not selected included. Less than all: `batch` is complete, and the
  /// rest belongs to the next one. Begin each batch with no samples in it; its other fields are set with its
  /// first sample.
  std::size_t Fill(std::span<const exchange::Sample> samples, Batch& batch);

 private:
  void Count(const exchange::Sample& sample);
  void Append(const exchange::Sample& sample, Batch& batch);

  const uint32_t decimation_;
  const std::size_t max_batch_;
  const uint64_t first_tick_;
  // The last sample seen.
  bool started_ = false;
  uint64_t last_tick_ = 0;
  uint64_t last_missed_ticks_ = 0;
  // Absent ticks that no batch has told yet.
  uint64_t missed_ = 0;
  uint64_t dropped_ = 0;
};

}  // namespace mwidth::record
