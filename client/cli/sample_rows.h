// Samples as rows of text.
#pragma once

#include <mwidth/v1/telemetry.pb.h>

#include <cstdint>
#include <memory>
#include <ostream>

#include "client/cli/units.h"

namespace mwidth::cli {

/// Writes samples one a row. Not thread-safe.
class SampleRows {
 public:
  SampleRows() = default;
  SampleRows(const SampleRows&) = delete;
  SampleRows& operator=(const SampleRows&) = delete;
  virtual ~SampleRows() = default;

  /// Writes the sample at `index` of `batch`, below the head where it is the first.
  virtual void Write(const v1::SampleBatch& batch, int index) = 0;
};

/// CSV (RFC 4180 without quotes, lines end in a newline): tick, monotonic_ns, position, velocity,
/// acceleration, force, mass, state, saturated, position_counts, force_counts, acceleration_counts; where
/// there are `extremes`, then position_min, position_max and those of velocity, acceleration and force. The
/// units are in the head. 17 significant digits.
std::unique_ptr<SampleRows> CsvRows(std::ostream& out, const Units& units, bool extremes = false);
/// Aligned columns for a terminal; the head is repeated every 20 rows. Time counts from the first sample.
std::unique_ptr<SampleRows> TableRows(std::ostream& out, const Units& units);

/// Tick of the sample at `index`.
uint64_t TickOf(const v1::SampleBatch& batch, int index);

}  // namespace mwidth::cli
