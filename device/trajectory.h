// A smooth position over time, pieced together before the loop starts and evaluated inside it.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace mwidth::device {

/// Where a motion is and how it goes on: position in m or rad, per s, per s^2.
struct MotionState {
  double position = 0;
  double velocity = 0;
  double acceleration = 0;
};

/// Natural cubic spline through samples: position, velocity and acceleration are continuous, the acceleration
/// is 0 at both ends.
struct CubicSpline {
  /// `times_s` rises; both have the same size, at least 2.
  CubicSpline(std::vector<double> times_s, std::vector<double> positions);

  MotionState Start() const { return {positions.front(), velocities.front(), 0}; }
  MotionState End() const { return {positions.back(), velocities.back(), 0}; }

  std::vector<double> times_s;
  std::vector<double> positions;
  std::vector<double> velocities;
};

/// Polynomial pieces end to end, each beginning as the one before ends: so position, velocity and
/// acceleration are continuous throughout. Begins at rest at time 0.
class Trajectory {
 public:
  explicit Trajectory(double position) : end_{position, 0, 0} {}

  /// Goes to `end` in `duration_s` (above 0) with the least jerk: the quintic that meets the state at both
  /// ends. From rest to rest this is 10 s^3 - 15 s^4 + 6 s^5 (Flash and Hogan 1985).
  void MoveTo(const MotionState& end, double duration_s);
  /// Stays in place. Precondition: at rest.
  void Hold(double duration_s) { MoveTo(end_, duration_s); }
  /// Follows `spline` from its first sample to its last. Precondition: the trajectory has reached
  /// spline.Start().
  void Follow(const CubicSpline& spline);
  /// After the end goes on from `time_s` again, for ever. Smooth where the state there is the state at the
  /// end.
  void RepeatFrom(double time_s) { repeat_from_s_ = time_s; }

  double end_s() const { return end_s_; }
  /// Position at `time_s`; before 0 the first. Precondition: not empty. Rt.
  double PositionAt(double time_s) const noexcept;

 private:
  /// Coefficients of the powers of the time since the piece's start, the constant first.
  using Polynomial = std::array<double, 6>;
  void Append(const Polynomial& polynomial, const MotionState& end, double duration_s);

  MotionState end_;
  double end_s_ = 0;
  double repeat_from_s_ = 0;
  std::vector<double> starts_s_;
  std::vector<Polynomial> polynomials_;
};

}  // namespace mwidth::device
