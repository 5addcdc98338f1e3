#include "server/model/crossing_range.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>

#include "server/model/linear_estimator.h"
#include "server/model/m_width.h"
#include "tests/server/model/plant_boxes.h"

namespace mwidth::model {
namespace {

constexpr double kPeriod = 0x1p-10;

Interval Around(double x, double low_factor, double high_factor) {
  return {x * low_factor, std::min(x * high_factor, 1.0)};
}

TEST(EstimatorRange, HoldsTheEstimatorOnTheArc) {
  RandomPlants random(21);
  for (int i = 0; i < 2000; ++i) {
    const EstimatorKind kind = kEstimatorKinds.at(static_cast<std::size_t>(i) % kEstimatorKinds.size());
    const double cutoff_hz = random.LogUniform(0.1, CutoffRangeOf(kind).max / kPeriod);
    const double angle = random.LogUniform(1e-5, std::numbers::pi);
    const double half_sine = std::sin(angle / 2);
    const double x = half_sine * half_sine;
    const Arc arc(Around(x, random.Uniform(0.5, 1), random.Uniform(1, 2)));
    const CircleRange range = EstimatorRange(kind, kPeriod, cutoff_hz).Over(arc);
    const std::complex<double> response =
        EstimatorOf({.period_s = kPeriod, .cutoff_hz = cutoff_hz, .estimator = kind})
            .Response(AtFrequency(angle / (2 * std::numbers::pi * kPeriod), kPeriod));
    const std::complex<double> factor = -kPeriod * kPeriod * response / (4 * x);
    const double rounding = 1e-10;
    EXPECT_GE(factor.real(), range.re.lo - rounding);
    EXPECT_LE(factor.real(), range.re.hi + rounding);
    const double im = factor.imag() / std::sin(angle);
    if (angle < 3.1) {
      EXPECT_GE(im, range.im.lo * (1 + rounding));
      EXPECT_LE(im, range.im.hi * (1 - rounding));
    }
  }
}

// The nominal edges are crossings: whatever box and arc hold one, the bounds must.
TEST(CrossingRange, HoldsTheCrossingsOfEveryPlantOfABox) {
  RandomPlants random(22);
  int held = 0;
  for (int i = 0; i < 8000; ++i) {
    const PlantBox box = random.Box(kPeriod);
    const PlantRange range = Enclose(box, {kPeriod});
    const double cutoff_hz = random.LogUniform(0.5, 0.48 / kPeriod);
    const EstimatorKind kind = kEstimatorKinds.at(static_cast<std::size_t>(i) % kEstimatorKinds.size());
    LoopParameters loop = random.Inside(box, kPeriod);
    loop.cutoff_hz = cutoff_hz;
    loop.estimator = kind;
    const MWidth width = ComputeMWidth(loop);
    ASSERT_FALSE(width.empty());
    for (const MassSign sign : {MassSign::kNegative, MassSign::kPositive}) {
      const Edge& edge = sign == MassSign::kNegative ? width.lower : width.upper;
      const double half_sine = std::sin(std::numbers::pi * edge.critical_hz * kPeriod);
      const double x = std::min(half_sine * half_sine, 1.0);
      // A crossing at z = -1 or z = 1 is no crossing of an arc but of the point.
      const bool at_end = x < 1e-25 || 1 - x < 1e-12;
      const Arc arc(at_end ? Exactly(std::round(x))
                           : Around(x, random.Uniform(0.9, 1 - 1e-7), random.Uniform(1 + 1e-7, 1.1)));
      const LoopRange factor =
          LoopFactor(EstimatorRange(kind, kPeriod, cutoff_hz), arc, range, box.delay_ticks);
      const CrossingSizes sizes = BoundCrossings(arc, range, factor, sign);
      const double size = std::abs(edge.mass);
      ASSERT_LE(sizes.lo, size * (1 + 1e-9)) << i;
      ASSERT_GE(sizes.hi, size * (1 - 1e-9)) << i;
      held += sizes.lo > 0 ? 1 : 0;
      PlantBox narrowed = box;
      if (Narrow(narrowed, arc, range, factor, sign, {.lo = 0.9 * size, .hi = 1.1 * size})) {
        const PlantRange after = Enclose(narrowed, {kPeriod});
        ASSERT_NE(after.knowledge, PlantKnowledge::kNone) << i;
        const double alpha = loop.device_damping * kPeriod / (2 * loop.device_mass);
        EXPECT_LE(after.alpha.lo, alpha * (1 + 1e-9));
        EXPECT_GE(after.alpha.hi, alpha * (1 - 1e-9));
      }
    }
  }
  EXPECT_GT(held, 4000);
}

TEST(CrossingRange, ExcludesAnArcWithoutCrossings) {
  // 1 kg with 10 N s/m and 100 N/m: far above its natural frequency of 1.6 Hz it resists any negative mass
  // below its own, and below it the spring does.
  const PlantBox box{.mass = {0.9, 1.1}, .damping = {9, 11}, .stiffness = {90, 110}};
  const PlantRange range = Enclose(box, {kPeriod});
  const double x = 1e-8;  // 0.03 Hz
  const Arc arc({0.5 * x, x});
  const LoopRange factor =
      LoopFactor(EstimatorRange(EstimatorKind::kFilteredDifference, kPeriod, 10), arc, range, 0);
  EXPECT_TRUE(BoundCrossings(arc, range, factor, MassSign::kNegative).none());
}

}  // namespace
}  // namespace mwidth::model
