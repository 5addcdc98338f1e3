// How much of what the stability model assumes away is borne before it is a fault.
#pragma once

#include <cstdint>

namespace mwidth::render {

/// Thresholds of the watches; server/render/README.md says what each of them sees and what it cannot see. Of
/// every window, each of the four times may be spent; more is a fault.
struct WatchConfig {
  /// Length of the sliding window, 0.1 to 10 s.
  double window_s = 1;
  /// The wanted force beyond the force limit; the wanted change of force beyond the slew limit. Each 0 to
  /// window_s.
  double saturation_s = 0.1;
  double slew_s = 0.1;
  /// No fresh position, or a force that the drive did not take: a silent drive and missed ticks. 0 to
  /// window_s.
  double gap_s = 0.2;
  /// Ticks whose force came later than delay_limit_s after their position. 0 to window_s.
  double late_s = 0.1;
  /// Longest delay from a position to its force that counts as certified, 0 to 0.04 s.
  double delay_limit_s = 0;
  /// Ticks in a row of which each missed a deadline; more is a fault. At most 1000.
  uint32_t max_consecutive_overruns = 10;

  /// Acceleration that no joint has, m/s^2 or rad/s^2: where positions demand more, the encoder jumped; where
  /// an accelerometer tells more, it lies. Above 0; no default, since the velocity limit and the period
  /// decide.
  double acceleration_limit = 0;
  /// Counts that stop from at least freeze_velocity (above 0; no default) within one answer, and then stay
  /// the same for freeze_s, 0.01 to 10 s, are those of a frozen encoder. What an accelerometer sums up to,
  /// forgotten in freeze_s, may be off the encoder's velocity by freeze_velocity and what the counts explain.
  double freeze_velocity = 0;
  double freeze_s = 0.1;
};

}  // namespace mwidth::render
