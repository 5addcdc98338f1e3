#include "device/trajectory.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace mwidth::device {
namespace {

/// Velocities that make the acceleration continuous at inner samples and 0 at the ends: a tridiagonal system,
/// diagonally dominant, so elimination needs no pivots (the Thomas algorithm).
std::vector<double> SplineVelocities(const std::vector<double>& times_s,
                                     const std::vector<double>& positions) {
  const std::size_t n = times_s.size();
  std::vector<double> above(n);
  std::vector<double> velocities(n);
  for (std::size_t i = 0; i < n; ++i) {
    // Row i: before v(i-1) + (2 before + 2 after) v(i) + after v(i+1) = 3 (before slope before + after slope
    // after).
    const double before = i > 0 ? 1 / (times_s[i] - times_s[i - 1]) : 0;
    const double after = i + 1 < n ? 1 / (times_s[i + 1] - times_s[i]) : 0;
    double right = 0;
    if (i > 0) {
      right += 3 * before * before * (positions[i] - positions[i - 1]);
    }
    if (i + 1 < n) {
      right += 3 * after * after * (positions[i + 1] - positions[i]);
    }
    const double eliminated_above = i > 0 ? above[i - 1] : 0;
    const double eliminated_right = i > 0 ? velocities[i - 1] : 0;
    const double pivot = 2 * (before + after) - before * eliminated_above;
    above[i] = after / pivot;
    velocities[i] = (right - before * eliminated_right) / pivot;
  }
  for (std::size_t i = n - 1; i > 0; --i) {
    velocities[i - 1] -= above[i - 1] * velocities[i];
  }
  return velocities;
}

}  // namespace

CubicSpline::CubicSpline(std::vector<double> sample_times_s, std::vector<double> sample_positions)
    : times_s(std::move(sample_times_s)),
      positions(std::move(sample_positions)),
      velocities(SplineVelocities(times_s, positions)) {}

void Trajectory::Append(const Polynomial& polynomial, const MotionState& end, double duration_s) {
  starts_s_.push_back(end_s_);
  polynomials_.push_back(polynomial);
  end_s_ += duration_s;
  end_ = end;
}

void Trajectory::MoveTo(const MotionState& end, double duration_s) {
  const double t = duration_s;
  // What the first three terms leave for the last three to make up at the end.
  const double way = end.position - end_.position - t * (end_.velocity + t * end_.acceleration / 2);
  const double velocity = (end.velocity - end_.velocity - t * end_.acceleration) * t;
  const double acceleration = (end.acceleration - end_.acceleration) * t * t;
  const double t3 = t * t * t;
  Append(
      {end_.position, end_.velocity, end_.acceleration / 2, (10 * way - 4 * velocity + acceleration / 2) / t3,
       (-15 * way + 7 * velocity - acceleration) / (t3 * t),
       (6 * way - 3 * velocity + acceleration / 2) / (t3 * t * t)},
      end, duration_s);
}

void Trajectory::Follow(const CubicSpline& spline) {
  for (std::size_t i = 0; i + 1 < spline.times_s.size(); ++i) {
    const double t = spline.times_s[i + 1] - spline.times_s[i];
    const double slope = (spline.positions[i + 1] - spline.positions[i]) / t;
    const double from = spline.velocities[i];
    const double to = spline.velocities[i + 1];
    Append({spline.positions[i], from, (3 * slope - 2 * from - to) / t, (from + to - 2 * slope) / (t * t)},
           {spline.positions[i + 1], to, 0}, t);
  }
}

double Trajectory::PositionAt(double time_s) const noexcept {
  double time = std::max(time_s, 0.0);
  if (time >= end_s_) {
    time = repeat_from_s_ + std::fmod(time - repeat_from_s_, end_s_ - repeat_from_s_);
  }
  const auto after = std::upper_bound(starts_s_.begin(), starts_s_.end(), time);
  const auto piece = static_cast<std::size_t>(std::distance(starts_s_.begin(), after)) - 1;
  const double t = time - starts_s_[piece];
  const Polynomial& p = polynomials_[piece];
  return p[0] + t * (p[1] + t * (p[2] + t * (p[3] + t * (p[4] + t * p[5]))));
}

}  // namespace mwidth::device
