// Reads recorded reaches from a CSV file.
#pragma once

#include <filesystem>
#include <vector>

#include "server/model/axis_kind.h"

namespace mwidth::device {

/// One recorded reach: times in s that rise from 0, positions in m or rad. At least kMinSamples of each.
struct Reach {
  static constexpr std::size_t kMinSamples = 4;

  std::vector<double> times_s;
  std::vector<double> positions;
};

/// Reads all reaches of a comma-separated file: a header line, which names a column time_s and one position
/// column (its name ends in _rad for a rotary axis, in _m for a linear one; other columns are ignored), then
/// one line per sample. A reach begins where the time is 0. At least one reach. Throws std::runtime_error
/// with file, line, what is wrong and what is expected. Not Rt.
std::vector<Reach> ReadRecording(const std::filesystem::path& file, model::AxisKind kind);

}  // namespace mwidth::device
