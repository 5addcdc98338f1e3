#include "device/trajectory.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

namespace mwidth::device {
namespace {

constexpr double kStepS = 1e-4;

/// Evenly spaced values from `from` on, below `to`.
std::vector<double> Steps(double from, double to, double step) {
  std::vector<double> values;
  for (int i = 0; from + i * step < to; ++i) {
    values.push_back(from + i * step);
  }
  return values;
}

double VelocityAt(const Trajectory& trajectory, double time_s) {
  return (trajectory.PositionAt(time_s + kStepS) - trajectory.PositionAt(time_s - kStepS)) / (2 * kStepS);
}

TEST(Trajectory, MovesFromRestToRestByFlashAndHogansPolynomial) {
  Trajectory trajectory(1);
  trajectory.MoveTo({3, 0, 0}, 0.5);
  for (const double s : Steps(0, 1, 0.05)) {
    const double expected = 1 + 2 * (10 * std::pow(s, 3) - 15 * std::pow(s, 4) + 6 * std::pow(s, 5));
    EXPECT_NEAR(trajectory.PositionAt(0.5 * s), expected, 1e-14);
  }
}

TEST(Trajectory, MeetsPositionVelocityAndAccelerationAtBothEndsOfAMove) {
  // One known quintic, cut at 0.3 s: the move through its two ends must be that quintic again.
  const auto position = [](double t) { return 2 - t + 3 * t * t - 4 * std::pow(t, 3) + std::pow(t, 5); };
  const auto state = [&](double t) {
    return MotionState{position(t), -1 + 6 * t - 12 * t * t + 5 * std::pow(t, 4),
                       6 - 24 * t + 20 * std::pow(t, 3)};
  };
  Trajectory trajectory(0);
  trajectory.MoveTo(state(0), 1);
  trajectory.MoveTo(state(0.3), 0.3);
  for (const double t : Steps(0, 0.3, 0.01)) {
    EXPECT_NEAR(trajectory.PositionAt(1 + t), position(t), 1e-13);
  }
}

TEST(Trajectory, RestsBeforeTimeZeroAndDuringAHold) {
  Trajectory trajectory(0.7);
  trajectory.Hold(2);
  EXPECT_EQ(trajectory.PositionAt(-1), 0.7);
  EXPECT_EQ(trajectory.PositionAt(0), 0.7);
  EXPECT_EQ(trajectory.PositionAt(1.3), 0.7);
}

TEST(Trajectory, RepeatsForeverFromTheChosenTime) {
  Trajectory trajectory(0);
  trajectory.MoveTo({1, 0, 0}, 1);
  trajectory.MoveTo({2, 0, 0}, 1);
  trajectory.MoveTo({1, 0, 0}, 1);
  trajectory.RepeatFrom(1);
  for (const double t : Steps(1, 3, 0.13)) {
    EXPECT_NEAR(trajectory.PositionAt(t + 2), trajectory.PositionAt(t), 1e-12);
    EXPECT_NEAR(trajectory.PositionAt(t + 2e6), trajectory.PositionAt(t), 1e-8);
  }
}

/// Second derivatives of the piece after sample i of a Hermite spline, at its beginning and at its end.
std::pair<double, double> Accelerations(const CubicSpline& spline, std::size_t i) {
  const double t = spline.times_s[i + 1] - spline.times_s[i];
  const double slope = (spline.positions[i + 1] - spline.positions[i]) / t;
  const double from = spline.velocities[i];
  const double to = spline.velocities[i + 1];
  return {(6 * slope - 4 * from - 2 * to) / t, (2 * from + 4 * to - 6 * slope) / t};
}

TEST(CubicSpline, PassesThroughUnevenSamplesWithContinuousVelocityAndAcceleration) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(0.05, 0.15);
  std::vector<double> times_s{0};
  std::vector<double> positions{0.4};
  for (int i = 0; i < 30; ++i) {
    times_s.push_back(times_s.back() + uniform(random));
    positions.push_back(positions.back() + uniform(random) - 0.1);
  }
  const CubicSpline spline(times_s, positions);
  Trajectory trajectory(0);
  trajectory.MoveTo(spline.Start(), 1);
  trajectory.Follow(spline);
  for (std::size_t i = 0; i + 1 < times_s.size(); ++i) {
    const double time_s = 1 + times_s[i];
    EXPECT_NEAR(trajectory.PositionAt(time_s), positions[i], 1e-13);
    EXPECT_NEAR(VelocityAt(trajectory, time_s), spline.velocities[i], 1e-3);
  }
  EXPECT_NEAR(trajectory.PositionAt(trajectory.end_s() - 1e-12), positions.back(), 1e-10);
  for (std::size_t i = 1; i + 1 < times_s.size(); ++i) {
    EXPECT_NEAR(Accelerations(spline, i - 1).second, Accelerations(spline, i).first, 1e-10);
  }
  EXPECT_NEAR(Accelerations(spline, 0).first, 0, 1e-10);
  EXPECT_NEAR(Accelerations(spline, times_s.size() - 2).second, 0, 1e-10);
}

TEST(CubicSpline, IsExactForAStraightLine) {
  const CubicSpline spline({0, 0.5, 0.6, 2}, {1, 2, 2.2, 5});
  for (const double velocity : spline.velocities) {
    EXPECT_NEAR(velocity, 2, 1e-14);
  }
}

TEST(CubicSpline, FollowsASmoothMotionBetweenItsSamples) {
  // Half a period of a sine has no acceleration at its ends, as the spline has none: the error falls as h^4.
  std::vector<double> times_s;
  std::vector<double> positions;
  for (int i = 0; i <= 100; ++i) {
    times_s.push_back(i * 0.01);
    positions.push_back(std::sin(std::numbers::pi * times_s.back()));
  }
  const CubicSpline spline(times_s, positions);
  Trajectory trajectory(0);
  trajectory.MoveTo(spline.Start(), 1);
  trajectory.Follow(spline);
  for (const double t : Steps(0.003, 1, 0.01)) {
    EXPECT_NEAR(trajectory.PositionAt(1 + t), std::sin(std::numbers::pi * t), 1e-8);
  }
}

}  // namespace
}  // namespace mwidth::device
