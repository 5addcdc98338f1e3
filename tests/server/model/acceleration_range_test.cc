#include "server/model/acceleration_range.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "server/model/accelerometer.h"
#include "server/model/estimator_range.h"
#include "server/model/plant_range.h"
#include "tests/server/model/plant_boxes.h"

namespace mwidth::model {
namespace {

constexpr double kPeriod = 0x1p-10;

// Sensors slow and fast against the tick: rates 0.006 to 600.
LoopParameters Sensed(LoopParameters plant, double bandwidth_hz) {
  plant.estimator = EstimatorKind::kAccelerometer;
  plant.cutoff_hz = 10;
  plant.accelerometer_bandwidth_hz = bandwidth_hz;
  return plant;
}

PlantSampling SamplingOf(double bandwidth_hz) {
  const EstimatorRange sensor(EstimatorKind::kAccelerometer, kPeriod, 10, bandwidth_hz);
  return {.period_s = kPeriod, .sensor_rate = sensor.sensor_rate()};
}

// e0, e1 and e2 of one plant, from what accelerometer_test.cc holds against the matrix exponential. A
// fraction of a tick that is there in the box alone leaves the same numerator times z.
std::array<double, 3> RiseOf(const LoopParameters& loop, bool delayed_box) {
  const SampledPlant plant = Discretize(loop);
  const SampledAcceleration acceleration = DiscretizeAcceleration(loop, plant);
  const double scale = (plant.hold[0] + plant.hold[1] + plant.hold[2]) * acceleration.sensor.circle.at_c;
  const auto& n = acceleration.rise;
  if (delayed_box && plant.hold[2] == 0) {
    return {n[0] / scale, (n[0] + n[1]) / scale, n[1] / scale};
  }
  return {n[0] / scale, n[1] / scale, n[2] / scale};
}

TEST(AccelerationRange, HoldsWhatIsSensedOfEveryPlantOfABox) {
  RandomPlants random(71);
  int bounded = 0;
  for (int i = 0; i < 4000; ++i) {
    PlantBox box = random.Box(kPeriod);
    if (i % 2 == 0) {  // everyday plants
      for (Interval* range : {&box.damping, &box.stiffness}) {
        range->lo = std::min(range->lo, 100.0) * 0.1;
        range->hi = std::min(range->hi, 100.0) * 0.1 + range->lo;
      }
    }
    const double bandwidth_hz = random.LogUniform(1, 1e5);
    const PlantRange range = Enclose(box, SamplingOf(bandwidth_hz));
    if (range.knowledge == PlantKnowledge::kUnbounded) {
      continue;
    }
    ++bounded;
    for (int member = 0; member < 8; ++member) {
      const LoopParameters loop = Sensed(random.Inside(box, kPeriod), bandwidth_hz);
      const std::array<double, 3> exact = RiseOf(loop, box.fraction.hi > 0);
      const double size = std::abs(exact[1]) + std::abs(exact[2]) + std::abs(exact[0]);
      for (std::size_t k = 0; k < exact.size(); ++k) {
        ASSERT_GE(exact.at(k), range.rise.at(k).lo - 1e-11 * size) << "box " << i << ", e" << k;
        ASSERT_LE(exact.at(k), range.rise.at(k).hi + 1e-11 * size) << "box " << i << ", e" << k;
      }
    }
  }
  EXPECT_GT(bounded, 2500);
}

TEST(AccelerationRange, IsNarrowForOnePlantAndForPlantsThatHardlyDiffer) {
  RandomPlants random(72);
  for (int i = 0; i < 2000; ++i) {
    PlantBox box;
    box.mass = Exactly(random.LogUniform(1e-2, 1));
    const double alpha = random.LogUniform(1e-6, 2);
    const double kappa = random.LogUniform(1e-8, 1);
    const double wide = i % 2 == 0 ? 0 : 1e-3;
    const double damping = 2 * alpha * box.mass.lo / kPeriod;
    const double stiffness = kappa * box.mass.lo / (kPeriod * kPeriod);
    box.damping = {damping, damping * (1 + wide)};
    box.stiffness = {stiffness, stiffness * (1 + wide)};
    box.fraction = i % 3 == 0 ? Exactly(0) : Exactly(random.OnGrid(random.Uniform(0, 1)));
    const PlantRange range = Enclose(box, SamplingOf(random.LogUniform(1, 9e3)));
    const double allowed = i % 2 == 0 ? 1e-7 : 1e-2 * (alpha + kappa) + 1e-7;
    const double size = 1 + std::abs(range.rise[1].hi);
    // e0 as a share of kappa, of which it is one.
    EXPECT_LT(range.rise[0].width(), (allowed + wide) * kappa * size + 1e-12) << i;
    EXPECT_LT(range.rise[1].width(), allowed * size) << i;
    EXPECT_LT(range.rise[2].width(), allowed * size) << i;
  }
}

}  // namespace
}  // namespace mwidth::model
