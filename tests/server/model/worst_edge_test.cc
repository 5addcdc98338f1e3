#include "server/model/worst_edge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "server/model/m_width.h"
#include "tests/server/model/model_loops.h"

namespace mwidth::model {
namespace {

PlantBox BoxOf(const LoopParameters& loop) {
  PlantBox box;
  box.mass = Exactly(loop.device_mass + loop.hand_mass);
  box.damping = Exactly(loop.device_damping + loop.hand_damping);
  box.stiffness = Exactly(loop.hand_stiffness);
  const double ticks = loop.delay_s / loop.period_s;
  box.delay_ticks = static_cast<int>(ticks);
  box.fraction = Exactly(ticks - box.delay_ticks);
  return box;
}

Sampling SamplingOf(const LoopParameters& loop) {
  return {.period_s = loop.period_s,
          .cutoff_hz = loop.cutoff_hz,
          .estimator = loop.estimator,
          .accelerometer_bandwidth_hz = loop.accelerometer_bandwidth_hz};
}

double NominalSize(const MWidth& width, MassSign sign) {
  return sign == MassSign::kNegative ? -width.lower.mass : width.upper.mass;
}

// Devices and hands of every kind, delays whole and fractional. The proof stays within its tolerance of what
// the closed form says, from below.
TEST(WorstEdge, OfOneLoopIsItsNominalEdge) {
  RandomLoops random(31);
  const SearchEffort effort{.tolerance = 1e-6, .max_boxes = 20000};
  for (int i = 0; i < 3000; ++i) {
    LoopParameters loop = random.Next();
    loop.estimator = kAllEstimatorKinds.at(static_cast<std::size_t>(i) % kAllEstimatorKinds.size());
    const std::vector<PlantBox> boxes{BoxOf(loop)};
    for (const MassSign sign : {MassSign::kNegative, MassSign::kPositive}) {
      const WorstEdge edge = FindWorstEdge(boxes, SamplingOf(loop), sign, effort);
      const double nominal = NominalSize(ComputeMWidth(loop), sign);
      EXPECT_LE(edge.proved, nominal * (1 + 1e-12)) << i;
      EXPECT_GE(edge.proved, nominal * (1 - 1e-6)) << i << " boxes " << edge.boxes;
    }
  }
}

// The search may end at any time: less is proved then, never too much.
TEST(WorstEdge, IsSoundWhateverTheEffort) {
  RandomLoops random(32);
  for (int i = 0; i < 100; ++i) {
    LoopParameters loop = random.Next();
    loop.estimator = kAllEstimatorKinds.at(static_cast<std::size_t>(i) % kAllEstimatorKinds.size());
    PlantBox box = BoxOf(loop);
    box.stiffness.hi *= 2;
    box.damping.lo /= 2;
    const std::vector<PlantBox> boxes{box};
    double before = 0;
    for (const int max_boxes : {1, 10, 100, 1000, 10000}) {
      const WorstEdge edge = FindWorstEdge(boxes, SamplingOf(loop), MassSign::kNegative,
                                           {.tolerance = 1e-3, .max_boxes = max_boxes});
      EXPECT_GE(edge.proved, before);
      EXPECT_LE(edge.proved, edge.found);
      EXPECT_LE(edge.found, NominalSize(ComputeMWidth(loop), MassSign::kNegative));
      before = edge.proved;
    }
  }
}

TEST(WorstEdge, OfSeveralBoxesIsThatOfTheWorst) {
  const LoopParameters loop = TableTwo();
  LoopParameters light = loop;
  light.device_mass /= 2;
  const std::vector<PlantBox> boxes{BoxOf(loop), BoxOf(light)};
  const WorstEdge edge = FindWorstEdge(boxes, SamplingOf(loop), MassSign::kPositive, {1e-6, 10000});
  EXPECT_EQ(edge.binding_box, 1U);
  EXPECT_NEAR(edge.proved, ComputeMWidth(light).upper.mass, 1e-6 * edge.proved);
}

}  // namespace
}  // namespace mwidth::model
