// motion.tsv: the samples of a session on the regular grid of its ticks; and motion.json.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "server/record/export/bids_channels.h"
#include "server/record/session/session_reader.h"

namespace mwidth::record {

/// What is known once the samples are written.
struct MotionExtent {
  uint64_t samples = 0;
  uint64_t first_tick = 0;
  uint64_t last_tick = 0;
  int64_t first_monotonic_ns = 0;
  int64_t last_monotonic_ns = 0;
  /// Each filter that ran, with the tick from which on.
  std::vector<std::pair<uint64_t, exchange::Filter>> filters;

  /// Ticks with and without a sample.
  uint64_t rows() const { return samples == 0 ? 0 : last_tick - first_tick + 1; }
};

/// Row i belongs to tick first_tick + i. The standard has one SamplingFrequency and no time stamps that
/// readers rely on, so that a tick without a sample must be a row: of "n/a", the standard's mark of a missing
/// value. Throws std::runtime_error where ticks do not ascend.
MotionExtent WriteMotion(SessionReader& reader, const std::vector<BidsChannel>& channels,
                         const std::filesystem::path& file);

std::string MotionJson(const SessionInfo& info, const std::vector<BidsChannel>& channels,
                       const MotionExtent& extent);

}  // namespace mwidth::record
