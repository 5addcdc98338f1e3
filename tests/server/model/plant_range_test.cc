#include "server/model/plant_range.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/server/model/plant_boxes.h"
#include "tests/server/model/reference_sampled_plant.h"

namespace mwidth::model {
namespace {

// A power of two: delays in ticks are exact, and the reference has the same fraction as the box.
constexpr double kPeriod = 0x1p-10;

testing::AssertionResult Holds(const char* what, const Interval& interval, const Real& value) {
  // Forces that have no share have one of 1e-40 in the reference's 50 digits.
  const Real rounding = 1e-30;
  if (interval.lo - rounding <= value && value <= interval.hi + rounding) {
    return testing::AssertionSuccess();
  }
  return testing::AssertionFailure() << what << " = " << value << " is not in " << interval.lo << " .. "
                                     << interval.hi;
}

// All that PlantRange bounds, of one plant in 50 digits.
testing::AssertionResult HoldsPlant(const PlantRange& range, const LoopParameters& plant) {
  const ReferenceSampledPlant reference = DiscretizeIn50Digits(plant);
  const Real sum = reference.hold[0] + reference.hold[1] + reference.hold[2];
  const Real mass = plant.device_mass;
  const Real stiffness = Real(plant.hand_stiffness) * kPeriod * kPeriod;
  const Real moving = mass * (1 - reference.loss / 2) / sum;
  const Real damping = mass * reference.loss / sum;
  const Real offset = range.knowledge == PlantKnowledge::kBoundedFromHalfRate ? stiffness / 4 : Real(0);
  for (const auto& result :
       {Holds("k T^2", range.stiffness, stiffness), Holds("mu X", range.moving_mass, moving - offset),
        Holds("beta T Y", range.damping, damping),
        Holds("mu e^-alpha / C2", range.damped_mass, moving - damping / 2 - offset),
        Holds("n0", range.newest, reference.hold[0] / sum),
        Holds("n2", range.oldest, reference.hold[2] / sum)}) {
    if (!result) {
      return result;
    }
  }
  return testing::AssertionSuccess();
}

TEST(PlantRange, HoldsEveryPlantOfABox) {
  RandomPlants random(11);
  int bounded = 0;
  int aliased = 0;
  for (int i = 0; i < 1500; ++i) {
    const PlantBox box = random.Box(kPeriod);
    const PlantRange range = Enclose(box, {kPeriod});
    ASSERT_NE(range.knowledge, PlantKnowledge::kNone);
    if (range.knowledge == PlantKnowledge::kUnbounded) {
      continue;
    }
    ++bounded;
    aliased += range.knowledge == PlantKnowledge::kBoundedFromHalfRate ? 1 : 0;
    for (int member = 0; member < 4; ++member) {
      const LoopParameters plant = random.Inside(box, kPeriod);
      ASSERT_TRUE(HoldsPlant(range, plant))
          << "box " << i << ": mass " << plant.device_mass << " in " << box.mass.lo << ".." << box.mass.hi
          << ", damping " << plant.device_damping << " in " << box.damping.lo << ".." << box.damping.hi
          << ", stiffness " << plant.hand_stiffness << " in " << box.stiffness.lo << ".." << box.stiffness.hi
          << ", delay " << plant.delay_s / kPeriod;
    }
  }
  EXPECT_GT(bounded, 1000);
  EXPECT_GT(aliased, 50);
}

// Without division into ever smaller boxes, what is known of one plant must be nearly exact.
TEST(PlantRange, IsNarrowForOnePlant) {
  RandomPlants random(12);
  for (int i = 0; i < 2000; ++i) {
    PlantBox box = random.Box(kPeriod);
    for (Interval* range : {&box.mass, &box.damping, &box.stiffness, &box.fraction}) {
      range->hi = range->lo;
    }
    const PlantRange range = Enclose(box, {kPeriod});
    ASSERT_NE(range.knowledge, PlantKnowledge::kUnbounded);
    const double mass = std::max({box.mass.hi, range.moving_mass.hi, range.stiffness.hi});
    EXPECT_LT(range.moving_mass.width(), 2e-7 * mass);
    EXPECT_LT(range.damping.width(), 2e-7 * std::max(range.damping.hi, mass * range.alpha.hi));
    EXPECT_LT(range.damped_mass.width(), 2e-7 * mass);
    EXPECT_LT(range.newest.width() + range.oldest.width(), 2e-6);
  }
}

TEST(PlantRange, KnowsWhenNoPlantHasWhatIsAskedFor) {
  PlantBox box{.mass = {1, 2}, .damping = {10, 20}, .stiffness = {100, 200}};
  box.alpha = {0.5, 1};  // 20 T / 2 is 0.01
  EXPECT_EQ(Enclose(box, {kPeriod}).knowledge, PlantKnowledge::kNone);
}

}  // namespace
}  // namespace mwidth::model
