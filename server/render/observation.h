// What one tick knows before it decides.
#pragma once

#include <cstdint>
#include <optional>

#include "device/drive.h"
#include "server/exchange/crossing.h"

namespace mwidth::render {

struct Observation {
  uint64_t tick = 0;
  int64_t monotonic_ns = 0;
  /// Ticks skipped just before this one.
  uint64_t missed_ticks = 0;
  /// The drive answered; if not, the motion is the last one known.
  bool fresh = false;
  /// Where fresh: the continuous counts, and the ticks since the answer before.
  int64_t position_counts = 0;
  uint64_t answer_periods = 1;
  /// What is wrong with the drive, fresh or not.
  device::DriveTrouble trouble = device::DriveTrouble::kNone;
  uint16_t trouble_code = 0;
  double position = 0;
  /// Where fresh: what the accelerometer told with the position; 0 without one.
  double sensed_acceleration = 0;
  double velocity = 0;
  double acceleration = 0;
  /// The force that has acted since the tick before.
  double force = 0;
  /// What the acceleration was estimated by.
  exchange::Filter filter{};
  /// From the position of the tick before to its force; none where one of them was not exchanged.
  std::optional<int64_t> loop_delay_ns;
};

}  // namespace mwidth::render
