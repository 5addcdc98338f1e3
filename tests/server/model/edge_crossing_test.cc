#include "server/model/edge_crossing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "server/model/estimator.h"
#include "tests/server/model/model_loops.h"

namespace mwidth::model {
namespace {

// The paper's loop with any hand and device, sampled fast or slowly, also so slowly that it aliases.
LoopParameters AnyLoop(RandomLoops& random) {
  LoopParameters loop = random.Next();
  loop.delay_s = 0;
  loop.hand_stiffness *= random.Uniform(0, 1) < 0.2 ? 0 : random.LogUniform(1e-2, 1e2);
  return loop;
}

struct Model {
  explicit Model(const LoopParameters& loop)
      : plant(Discretize(loop)),
        estimator(FactorsOf(loop.estimator, loop.period_s, loop.cutoff_hz)),
        moving_mass(loop.device_mass + loop.hand_mass) {}

  SampledPlant plant;
  EstimatorFactors estimator;
  double moving_mass;
};

void ExpectSame(const Crossing& actual, const Crossing& expected, const std::string& which) {
  EXPECT_NEAR(actual.mass, expected.mass, 1e-12 * std::abs(expected.mass)) << which;
  EXPECT_NEAR(actual.half_sine_squared, expected.half_sine_squared, 1e-12 * expected.half_sine_squared)
      << which;
}

TEST(EdgeCrossings, InClosedFormAreTheNearestOfAllCrossings) {
  RandomLoops random(21);
  int at_half_rate = 0;
  int aliased = 0;
  constexpr int kLoops = 20000;
  for (int i = 0; i < kLoops; ++i) {
    const Model model(AnyLoop(random));
    const EdgeCrossings edges = FindEdgeCrossings(model.plant, model.estimator, model.moving_mass);
    Crossing lower{.mass = -std::numeric_limits<double>::infinity()};
    Crossing upper{.mass = std::numeric_limits<double>::infinity()};
    for (const Crossing& crossing : FindCrossings(model.plant, model.estimator, model.moving_mass)) {
      Crossing& nearest = crossing.mass < 0 ? lower : upper;
      nearest = std::abs(crossing.mass) < std::abs(nearest.mass) ? crossing : nearest;
    }
    ExpectSame(edges.lower, lower, "lower edge of loop " + std::to_string(i));
    ExpectSame(edges.upper, upper, "upper edge of loop " + std::to_string(i));
    at_half_rate += edges.upper.half_sine_squared == 1 ? 1 : 0;
    aliased += model.plant.hold[1] <= 0 ? 1 : 0;
  }
  // Every way was taken.
  EXPECT_GT(at_half_rate, kLoops / 50);
  EXPECT_LT(at_half_rate, kLoops / 2);
  EXPECT_GT(aliased, 0);
}

TEST(EdgeCrossings, KeepTheirDigitsWhereDampingOrFilterAllButVanish) {
  LoopParameters loop = TableTwo();
  loop.hand_stiffness = loop.hand_damping = 0;
  for (const double small : {1e-60, 1e-69, 1e-71, 1e-100, 1e-250, 1e-307}) {
    loop.device_damping = small;
    const Model slow(loop);
    const EdgeCrossings edges = FindEdgeCrossings(slow.plant, slow.estimator, slow.moving_mass);
    EXPECT_NEAR(edges.lower.mass, -0.07, 1e-14) << small;
    EXPECT_GE(edges.lower.half_sine_squared, 0) << small;
  }
  // What the filter lets through of a slow swing is in proportion to its cut-off.
  loop = TableTwo();
  loop.cutoff_hz = 1e-50;
  const Model reference(loop);
  const EdgeCrossings expected =
      FindEdgeCrossings(reference.plant, reference.estimator, reference.moving_mass);
  for (const double cutoff_hz : {1e-60, 1e-69, 1e-75, 1e-100}) {
    loop.cutoff_hz = cutoff_hz;
    const Model model(loop);
    const EdgeCrossings edges = FindEdgeCrossings(model.plant, model.estimator, model.moving_mass);
    const double ratio = 1e-50 / cutoff_hz;
    EXPECT_NEAR(edges.lower.mass / expected.lower.mass / ratio, 1, 1e-13) << cutoff_hz;
    EXPECT_NEAR(edges.upper.mass / expected.upper.mass / ratio, 1, 1e-13) << cutoff_hz;
  }
}

}  // namespace
}  // namespace mwidth::model
