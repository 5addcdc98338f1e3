#include "device/hand_motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>

#include "tests/support/temporary_file.h"

namespace mwidth::device {
namespace {

using model::AxisKind;

constexpr double kPeriodS = 1e-3;

/// The largest acceleration, seen at 1 kHz, from `from_s` to `to_s`: a jump of 1 mrad would show as 1000
/// rad/s^2, one of the velocity by 0.1 rad/s as 100 rad/s^2.
double PeakAcceleration(const HandMotion& motion, double from_s, double to_s) {
  double peak = 0;
  const int ticks = static_cast<int>((to_s - from_s) / kPeriodS);
  for (int tick = 0; tick < ticks; ++tick) {
    const double t = from_s + tick * kPeriodS;
    peak = std::max(peak, std::abs(motion.PositionAt(t + kPeriodS) - 2 * motion.PositionAt(t) +
                                   motion.PositionAt(t - kPeriodS)) /
                              (kPeriodS * kPeriodS));
  }
  return peak;
}

/// Two reaches of half a cosine each, which begin and end in motion: cut out of a longer movement.
std::string TwoReaches() {
  std::ostringstream text;
  text << "time_s,angle_rad\n";
  for (const double start : {0.5, 1.1}) {
    for (int i = 0; i <= 50; ++i) {
      text << i * 0.01 << ',' << start + 0.25 - 0.25 * std::cos(0.3 + i * 0.05) << '\n';
    }
  }
  return text.str();
}

TEST(MinimumJerkReach, RestsReachesRestsAndReturns) {
  const MinimumJerkReach motion({.start_position = 0.2, .amplitude = 0.5, .duration_s = 0.6, .hold_s = 0.9});
  EXPECT_DOUBLE_EQ(motion.period_s(), 3);
  EXPECT_EQ(motion.PositionAt(0), 0.2);
  EXPECT_EQ(motion.PositionAt(0.9), 0.2);
  EXPECT_NEAR(motion.PositionAt(1.2), 0.45, 1e-12);
  EXPECT_NEAR(motion.PositionAt(2), 0.7, 1e-12);
  EXPECT_NEAR(motion.PositionAt(2.7), 0.45, 1e-12);
  EXPECT_NEAR(motion.PositionAt(3.5), 0.2, 1e-12);
  EXPECT_NEAR(motion.PositionAt(3001.2), 0.45, 1e-9);
}

TEST(MinimumJerkReach, AcceleratesAsLittleAsThePolynomialSays) {
  const MinimumJerkReach motion({.amplitude = 0.5, .duration_s = 0.6, .hold_s = 0.9});
  // The peak of s'' of 10 s^3 - 15 s^4 + 6 s^5 is 10/sqrt(3).
  EXPECT_NEAR(PeakAcceleration(motion, 0.01, 7), 0.5 / 0.36 * 10 / std::numbers::sqrt3, 0.01);
}

TEST(MinimumJerkReach, ReachesThirtyDegreesOnARotaryAxisByDefault) {
  const MinimumJerkReach motion(DefaultReach(AxisKind::kRotary));
  EXPECT_NEAR(motion.PositionAt(motion.period_s() / 2 + 0.1) * 180 / std::numbers::pi, 30, 1e-9);
  EXPECT_EQ(DefaultReach(AxisKind::kLinear).amplitude, 0.1);
}

TEST(MinimumJerkReach, RefusesTimesThatAreNotAboveZero) {
  EXPECT_THROW(MinimumJerkReach({.amplitude = 1, .duration_s = 0}), std::runtime_error);
  EXPECT_THROW(MinimumJerkReach({.amplitude = 1, .hold_s = -1}), std::runtime_error);
  EXPECT_THROW(MinimumJerkReach({.amplitude = std::numeric_limits<double>::quiet_NaN()}), std::runtime_error);
}

TEST(RecordedMotion, StartsAtRestAtTheFirstSample) {
  const TemporaryFile file(TwoReaches());
  const RecordedMotion motion(file.path(), AxisKind::kRotary);
  const double first = 0.75 - 0.25 * std::cos(0.3);
  EXPECT_NEAR(motion.PositionAt(0), first, 1e-5);
  EXPECT_NEAR(motion.PositionAt(1e-3), motion.PositionAt(0), 1e-7);
}

TEST(RecordedMotion, PlaysTheReachesOneAfterTheOtherAndThenAgain) {
  const TemporaryFile file(TwoReaches());
  const RecordedMotion motion(file.path(), AxisKind::kRotary);
  const double return_s = RecordedMotion::kReturnS;
  EXPECT_NEAR(motion.first_pass_s(), 3 * return_s + 2 * 0.5, 1e-12);
  const double pass_s = 2 * return_s + 2 * 0.5;
  for (int i = 0; i <= 50; ++i) {
    const double in_reach = 0.25 - 0.25 * std::cos(0.3 + i * 0.05);
    const double time_s = return_s + i * 0.01;
    EXPECT_NEAR(motion.PositionAt(time_s), 0.5 + in_reach, 1e-5);
    EXPECT_NEAR(motion.PositionAt(time_s + return_s + 0.5), 1.1 + in_reach, 1e-5);
    EXPECT_NEAR(motion.PositionAt(time_s + pass_s), 0.5 + in_reach, 1e-5);
    EXPECT_NEAR(motion.PositionAt(time_s + 100 * pass_s), 0.5 + in_reach, 1e-5);
  }
}

TEST(RecordedMotion, HasNoJumpOfPositionOrVelocityAnywhere) {
  const TemporaryFile file(TwoReaches());
  const RecordedMotion motion(file.path(), AxisKind::kRotary);
  // The reaches themselves accelerate by 0.25 * 5^2 = 6.3 rad/s^2; the returns stay in that order.
  EXPECT_LT(PeakAcceleration(motion, -0.1, 2.5 * motion.first_pass_s()), 15);
}

TEST(RecordedMotion, PlaysOnlyTheChosenReach) {
  const TemporaryFile file(TwoReaches());
  const RecordedMotion motion(file.path(), AxisKind::kRotary, 2);
  EXPECT_NEAR(motion.PositionAt(0), 1.35 - 0.25 * std::cos(0.3), 1e-5);
  EXPECT_NEAR(motion.first_pass_s(), 2 * RecordedMotion::kReturnS + 0.5, 1e-12);
  EXPECT_LT(PeakAcceleration(motion, -0.1, 10), 15);
}

TEST(RecordedMotion, RefusesAReachThatTheFileDoesNotHave) {
  const TemporaryFile file(TwoReaches());
  for (const std::size_t number : {0U, 3U}) {
    try {
      const RecordedMotion motion(file.path(), AxisKind::kRotary, number);
      ADD_FAILURE() << "reach " << number << " accepted";
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(file.path().string()));
      EXPECT_THAT(error.what(), testing::HasSubstr("expected 1 to 2"));
    }
  }
}

}  // namespace
}  // namespace mwidth::device
