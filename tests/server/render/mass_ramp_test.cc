#include "server/render/mass_ramp.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <random>

namespace mwidth::render {
namespace {

constexpr double kPeriodS = 1e-3;

TEST(MassRampTest, GoesInAStraightLineAndArrivesToTheBit) {
  MassRamp ramp(kPeriodS);
  ramp.SetTarget(0.3, 0.2);
  for (int k = 1; k <= 200; ++k) {
    EXPECT_FALSE(ramp.arrived());
    ramp.Advance(1);
    EXPECT_NEAR(ramp.mass(), 0.3 * k / 200, 1e-15);
  }
  EXPECT_TRUE(ramp.arrived());
  EXPECT_EQ(ramp.mass(), 0.3);
  ramp.Advance(5);
  EXPECT_EQ(ramp.mass(), 0.3);
}

TEST(MassRampTest, StartsANewTargetFromWhereItIs) {
  MassRamp ramp(kPeriodS);
  ramp.SetTarget(1, 0.1);
  ramp.Advance(40);
  const double reached = ramp.mass();
  EXPECT_NEAR(reached, 0.4, 1e-15);
  ramp.SetTarget(-0.6, 0.1);
  EXPECT_EQ(ramp.mass(), reached);
  ramp.Advance(1);
  EXPECT_NEAR(ramp.mass(), 0.39, 1e-15);
  ramp.Advance(99);
  EXPECT_EQ(ramp.mass(), -0.6);
}

TEST(MassRampTest, LetsMissedTicksPass) {
  MassRamp ramp(kPeriodS);
  ramp.SetTarget(1, 0.01);
  ramp.Advance(4);
  EXPECT_NEAR(ramp.mass(), 0.4, 1e-15);
  ramp.Advance(std::numeric_limits<uint64_t>::max());
  EXPECT_EQ(ramp.mass(), 1);
}

TEST(MassRampTest, TakesOneTickForARampOfNoTimeAndTheLongestForOneThatIsNoNumber) {
  MassRamp ramp(kPeriodS);
  for (const double no_time : {0.0, -1.0, -std::numeric_limits<double>::infinity()}) {
    ramp.Cut();
    ramp.SetTarget(1, no_time);
    EXPECT_EQ(ramp.mass(), 0);
    ramp.Advance(1);
    EXPECT_EQ(ramp.mass(), 1);
  }
  for (const double endless :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    ramp.Cut();
    ramp.SetTarget(1, endless);
    ramp.Advance(5000);
    EXPECT_NEAR(ramp.mass(), 0.5, 1e-12);
  }
}

TEST(MassRampTest, IsThereAtOnceWhenItIsThereAlready) {
  MassRamp ramp(kPeriodS);
  ramp.SetTarget(0, 0.2);
  EXPECT_TRUE(ramp.arrived());
}

TEST(MassRampTest, CutsToZero) {
  MassRamp ramp(kPeriodS);
  ramp.SetTarget(1, 0.2);
  ramp.Advance(50);
  ramp.Cut();
  EXPECT_TRUE(ramp.arrived());
  ramp.Advance(10);
  EXPECT_EQ(ramp.mass(), 0);
  EXPECT_EQ(ramp.target(), 0);
}

TEST(MassRampTest, NeverLeavesTheIntervalBetweenItsEnds) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> mass(-2, 2);
  std::uniform_real_distribution<double> time(0, 0.05);
  MassRamp ramp(kPeriodS);
  for (int i = 0; i < 20'000; ++i) {
    const double from = ramp.mass();
    // Ends that nearly touch are where rounding could step over.
    const double to = i % 3 == 0 ? from * (1 + 1e-16 * mass(random)) : mass(random);
    ramp.SetTarget(to, time(random));
    for (int k = 0; k < 30; ++k) {
      ramp.Advance(1);
      ASSERT_GE(ramp.mass(), std::min(from, to));
      ASSERT_LE(ramp.mass(), std::max(from, to));
    }
  }
}

}  // namespace
}  // namespace mwidth::render
