#include "device/hand_motion.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "device/recording.h"

namespace mwidth::device {
namespace {

Trajectory BackAndForth(const ReachParameters& reach) {
  if (!std::isfinite(reach.start_position) || !std::isfinite(reach.amplitude) ||
      !std::isfinite(reach.duration_s) || !std::isfinite(reach.hold_s) || reach.duration_s <= 0 ||
      reach.hold_s <= 0) {
    throw std::runtime_error("reach of " + std::to_string(reach.amplitude) + " in " +
                             std::to_string(reach.duration_s) + " s with rests of " +
                             std::to_string(reach.hold_s) + " s; expected finite values and times above 0");
  }
  Trajectory trajectory(reach.start_position);
  trajectory.Hold(reach.hold_s);
  trajectory.MoveTo({reach.start_position + reach.amplitude, 0, 0}, reach.duration_s);
  trajectory.Hold(reach.hold_s);
  trajectory.MoveTo({reach.start_position, 0, 0}, reach.duration_s);
  return trajectory;
}

std::vector<Reach> ChosenReaches(const std::filesystem::path& file, model::AxisKind kind,
                                 std::optional<std::size_t> reach_number) {
  std::vector<Reach> reaches = ReadRecording(file, kind);
  if (!reach_number) {
    return reaches;
  }
  if (*reach_number < 1 || *reach_number > reaches.size()) {
    throw std::runtime_error(file.string() + ": no reach " + std::to_string(*reach_number) +
                             "; expected 1 to " + std::to_string(reaches.size()));
  }
  return {reaches[*reach_number - 1]};
}

Trajectory Played(const std::vector<Reach>& reaches) {
  Trajectory trajectory(reaches.front().positions.front());
  MotionState first;
  for (const Reach& reach : reaches) {
    const CubicSpline spline(reach.times_s, reach.positions);
    trajectory.MoveTo(spline.Start(), RecordedMotion::kReturnS);
    if (&reach == &reaches.front()) {
      first = spline.Start();
      trajectory.RepeatFrom(trajectory.end_s());
    }
    trajectory.Follow(spline);
  }
  trajectory.MoveTo(first, RecordedMotion::kReturnS);
  return trajectory;
}

}  // namespace

ReachParameters DefaultReach(model::AxisKind kind) {
  ReachParameters reach;
  reach.amplitude = kind == model::AxisKind::kRotary ? std::numbers::pi / 6 : 0.1;
  return reach;
}

MinimumJerkReach::MinimumJerkReach(const ReachParameters& reach) : trajectory_(BackAndForth(reach)) {}

RecordedMotion::RecordedMotion(const std::filesystem::path& file, model::AxisKind kind,
                               std::optional<std::size_t> reach_number)
    : trajectory_(Played(ChosenReaches(file, kind, reach_number))) {}

}  // namespace mwidth::device
