// Whether an encoder's counts can be the positions of a joint.
#pragma once

#include <cstdint>

#include "server/render/breach.h"
#include "server/render/loop_config.h"

namespace mwidth::render {

/// Watches the drive's counts, in every state: a start must not build on an estimate that a broken encoder
/// has just thrown off. The loop's thread; all Rt.
///
/// Jump: two mean velocities v' and v, over n' periods and the n after them, differ by the acceleration
/// weighted with a triangle of area (n + n') T / 2, and rounding to counts of size q adds at most
/// (1/n + 1/n') q / T. The joint was therefore accelerated by at least
///
///     a = (|v - v'| - (1/n + 1/n') q / T) / ((n + n') T / 2)
///
/// somewhere in between, and where that is beyond what any joint does, the counts are wrong.
///
/// Freeze: the counts stopped dead while the joint was clearly moving, and have not changed since. A hand
/// that comes to rest slows down first.
class EncoderWatch {
 public:
  /// `position_quantum`: position of one count; above 0.
  EncoderWatch(const LoopConfig& config, double position_quantum) noexcept;

  /// The counts of an answer, `periods` (at least 1) after the answer before.
  void Follow(int64_t position_counts, uint64_t periods) noexcept;
  /// A jump within the last second, else a freeze that lasts.
  Breach Judge() const noexcept;

 private:
  void FollowJump(double velocity, uint64_t periods) noexcept;

  const double period_s_;
  const double quantum_;
  const double acceleration_limit_;
  const double freeze_velocity_;
  const uint64_t freeze_ticks_;
  const uint64_t jump_memory_ticks_;

  // How many answers are known without too long a gap: a velocity takes two.
  int answers_ = 0;
  int64_t counts_ = 0;
  double velocity_ = 0;
  uint64_t periods_ = 0;
  double jump_acceleration_ = 0;
  uint64_t ticks_since_jump_ = 0;
  // The last velocity that was not zero, and for how long it has been zero.
  double moving_velocity_ = 0;
  uint64_t still_ticks_ = 0;
};

}  // namespace mwidth::render
