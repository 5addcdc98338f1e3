// How the simulated person wants to move: the trajectory of the hand that pulls the device along.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>

#include "device/trajectory.h"
#include "server/model/axis_kind.h"

namespace mwidth::device {

/// The paper's x_h over time. Begins at rest at time 0 and goes on for ever.
class HandMotion {
 public:
  HandMotion() = default;
  HandMotion(const HandMotion&) = delete;
  HandMotion& operator=(const HandMotion&) = delete;
  virtual ~HandMotion() = default;

  /// Position of the hand, m or rad, at `time_s` (at least 0) since the start. Rt.
  virtual double PositionAt(double time_s) const noexcept = 0;
};

/// A reach to a target and back, again and again.
struct ReachParameters {
  /// Position at rest, and the way from there to the target; m or rad.
  double start_position = 0;
  double amplitude = 0;
  /// Time of each way, and of the rest before and after it; above 0.
  double duration_s = 0.6;
  double hold_s = 0.9;
};

/// The paper's single-joint reach of 30 degrees, or 0.1 m on a linear axis.
ReachParameters DefaultReach(model::AxisKind kind);

/// Rest, reach, rest, return with the minimum jerk of human reaches (Flash and Hogan 1985).
class MinimumJerkReach final : public HandMotion {
 public:
  /// Throws std::runtime_error when a parameter is not finite or a time is not above 0.
  explicit MinimumJerkReach(const ReachParameters& reach);

  double PositionAt(double time_s) const noexcept override { return trajectory_.PositionAt(time_s); }
  /// Time after which the motion repeats.
  double period_s() const { return trajectory_.end_s(); }

 private:
  Trajectory trajectory_;
};

/// Recorded reaches, one after the other or only one of them, then again from the first. Position, velocity
/// and acceleration are continuous: cubic splines through the samples, and between them returns of minimum
/// jerk that take kReturnS. The first second sets the hand in motion from rest at the first sample.
class RecordedMotion final : public HandMotion {
 public:
  static constexpr double kReturnS = 1;

  /// Reads `file` as ReadRecording does; `reach_number` counts from 1.
  /// Throws std::runtime_error where the file is wrong or has no such reach.
  RecordedMotion(const std::filesystem::path& file, model::AxisKind kind,
                 std::optional<std::size_t> reach_number = std::nullopt);

  double PositionAt(double time_s) const noexcept override { return trajectory_.PositionAt(time_s); }
  /// Time at which all chosen reaches have been played once, with the return to the first.
  double first_pass_s() const { return trajectory_.end_s(); }

 private:
  Trajectory trajectory_;
};

}  // namespace mwidth::device
