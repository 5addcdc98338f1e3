// Movements in a trial, and what is said of each: how far, how fast, how much too far, and how heavy it felt.
//
// The definitions are those of the Python package's mwidth.reaches where that has them: motion, onset,
// overshoot and perceived mass.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/session/trial.h"

namespace mwidth::cli::session {

/// Every tick of a trial: m or rad and their derivatives, N or N m, kg or kg m^2. Position is as recorded,
/// the derivatives are its own with zero phase, and the force passes through the same filter as they do.
/// Ticks without a sample are interpolated.
struct Motion {
  uint64_t first_tick = 0;
  double period_s = 0;
  double position_quantum = 0;
  std::vector<double> position{};
  std::vector<double> velocity{};
  std::vector<double> acceleration{};
  std::vector<double> force{};
  std::vector<double> mass{};
  /// The force that the loop's own estimator makes of the smooth motion with this mass, smoothed as `force`:
  /// what the model expects, without the encoder's counts, limits and silences. Empty where the trial's
  /// filter changes or reads an accelerometer.
  std::vector<double> expected_force{};

  double TimeOf(std::size_t index) const { return static_cast<double>(index) * period_s; }
};

/// Longest row of ticks without a position that is interpolated.
inline constexpr double kMaxGapS = 0.01;

/// None, and `why`, where the trial has a longer gap or fewer samples than the filter's window.
std::optional<Motion> MotionOf(const Trial& trial, const record::SessionAxis& axis, std::string& why);

/// Where a reach should go; m or rad.
struct Task {
  std::optional<double> start;
  std::optional<double> target;
};

/// From the keys target, target_rad, target_deg, target_m of a trial's metadata, and start, start_rad,
/// start_deg, start_m: a plain key is in the axis's own unit (rad or m). A text that is no finite number, and
/// a unit of the other kind of axis, count as not given.
Task TaskOf(const Trial& trial, bool rotary);

/// The device alone, as the loop's model has it.
struct Device {
  double mass = 0;
  double damping = 0;
};

struct Movement {
  /// Indices into the motion. Onset: the last sample slower than 5 % of the fastest of the trial. End: from
  /// there on it is slower than that for kRestS; or the end of the trial.
  std::size_t onset = 0;
  std::size_t peak = 0;
  std::size_t end = 0;
  bool came_to_rest = false;
  /// The end of that rest; otherwise the end. Where the movement led to is judged here.
  std::size_t settled = 0;
  /// Of the task; without one, the positions at onset and where it settled.
  double start = 0;
  double target = 0;
  bool target_given = false;

  double movement_time_s = 0;
  double time_to_peak_s = 0;
  /// Largest velocity toward the target; signed.
  double peak_velocity = 0;
  /// Farthest position beyond the target, until it settled, as a fraction of the way from start to target;
  /// negative: short of it.
  double overshoot = 0;
  /// It came back from there, or to rest: a trial that ends before does not tell how far it would have gone.
  bool turned = false;
  /// Position where it settled less the target.
  double end_error = 0;
  /// Of the force smoothed as the motion is.
  double peak_force = 0;
  double rms_force = 0;
  /// The commanded mass at onset; none where it changed before the end.
  std::optional<double> mass{};
  /// Eq. 23 with the hand's force m x'' + b x' + F_a over onset to end, and eq. 24. None without a device,
  /// or where device and mass cancel.
  std::optional<double> perceived_mass{};
  std::optional<double> error{};
  /// The same with the expected force.
  std::optional<double> expected_mass{};
  std::optional<double> expected_error{};
};

inline constexpr double kOnsetShare = 0.05;
inline constexpr double kRestS = 0.1;
inline constexpr double kLeastWayCounts = 50;

struct Movements {
  std::vector<Movement> found;
  /// Begun before the trial, or without a rest that would tell where they begin; without a target also those
  /// that come back.
  std::size_t left_out = 0;
};

/// With a target: every reach that passes the middle of the way, having been in its first quarter before.
/// Without: every movement between two rests that goes more than a fifth as far as the longest, and farther
/// than kLeastWayCounts of the encoder, and does not come back more than half of its way.
Movements FindMovements(const Motion& motion, const Task& task, const std::optional<Device>& device);

}  // namespace mwidth::cli::session
