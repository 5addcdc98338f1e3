// The discretization against the matrix exponential in 50 digits.
#include "server/model/plant.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tests/server/model/reference_sampled_plant.h"

namespace mwidth::model {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

// Relative to `expected`, or to `least` where that is larger.
double RelativeError(double actual, const Real& expected, double least) {
  const double size = std::max(std::abs(static_cast<double>(expected)), least);
  return size == 0 ? std::abs(actual) : std::abs(static_cast<double>(actual - expected)) / size;
}

// A share of the held force counts relative to itself, but below `negligible` times the newest one relative
// to that: what heavy damping leaves of an old force, e^-damping, may well lose its digits as long as it
// stays small.
double WorstError(const LoopParameters& loop, double negligible) {
  const SampledPlant plant = Discretize(loop);
  const ReferenceSampledPlant expected = DiscretizeIn50Digits(loop);
  double worst = std::max(RelativeError(plant.static_gap, expected.static_gap, 0),
                          RelativeError(plant.loss, expected.loss, 0));
  const double least = negligible * plant.hold[0];
  for (size_t i = 0; i < plant.hold.size(); ++i) {
    worst = std::max(worst, RelativeError(plant.hold[i], expected.hold[i], least));
  }
  return worst;
}

class Draw {
 public:
  double LogUniform(double low, double high) {
    return low * std::pow(high / low, std::uniform_real_distribution<double>()(random_));
  }
  // A period whose multiples and eighths are exact in binary: what the test measures is not the rounding of
  // the delay.
  double BinaryPeriod() { return std::ldexp(1, -std::uniform_int_distribution<int>(7, 16)(random_)); }
  double EighthsOfATick() { return std::uniform_int_distribution<int>(0, 24)(random_) / 8.0; }

 private:
  std::mt19937_64 random_{1};
};

// A unit mass with `damping` and `stiffness` per tick, alpha = damping/2 and kappa = stiffness.
LoopParameters PerTick(double damping, double stiffness, double period_s, double delay_ticks) {
  return {.device_mass = 1,
          .device_damping = damping / period_s,
          .hand_mass = 0,
          .hand_damping = 0,
          .hand_stiffness = stiffness / (period_s * period_s),
          .period_s = period_s,
          .cutoff_hz = 10,
          .delay_s = delay_ticks * period_s};
}

TEST(Discretize, IsExactToAFewUnitsInTheLastPlaceAtAnyDamping) {
  Draw draw;
  for (int i = 0; i < 400; ++i) {
    // Natural frequency times period from 1e-7 to 1, damping from nearly none to 3000 per tick.
    const double stiffness = std::pow(draw.LogUniform(1e-7, 1), 2);
    const double damping = draw.LogUniform(1e-9, 6000);
    const LoopParameters loop = PerTick(damping, stiffness, draw.BinaryPeriod(), draw.EighthsOfATick());
    EXPECT_LT(WorstError(loop, 1e-12), 24 * kEpsilon) << damping << " " << stiffness << " " << loop.delay_s;
  }
}

TEST(Discretize, IsExactNearCriticalDampingWhereItsFormulasMeet) {
  Draw draw;
  for (const double alpha : {1e-3, 0.1, 0.499, 0.5, 0.501, 0.999, 1.0, 1.001, 2.0, 5.0, 30.0}) {
    for (const double ratio : {0.0, 0.5, 0.7499, 0.75, 0.7501, 0.9, 1 - 1e-9, 1.0, 1 + 1e-9, 1.1, 2.0}) {
      const LoopParameters loop =
          PerTick(2 * alpha, ratio * alpha * alpha, draw.BinaryPeriod(), draw.EighthsOfATick());
      EXPECT_LT(WorstError(loop, 0.1), 24 * kEpsilon) << alpha << " " << ratio << " " << loop.delay_s;
    }
  }
}

TEST(Discretize, OfARandomLoopWithItsHandIsExact) {
  Draw draw;
  for (int i = 0; i < 300; ++i) {
    LoopParameters loop{.device_mass = draw.LogUniform(1e-3, 1e2),
                        .device_damping = draw.LogUniform(1e-4, 10),
                        .hand_mass = i % 2 == 0 ? 0 : draw.LogUniform(1e-3, 10),
                        .hand_damping = draw.LogUniform(1e-2, 300),
                        .hand_stiffness = i % 5 == 0 ? 0 : draw.LogUniform(1, 3e4),
                        .period_s = draw.LogUniform(1e-5, 1e-2),
                        .cutoff_hz = 10,
                        .delay_s = 0};
    const double mass = loop.device_mass + loop.hand_mass;
    const double angle = loop.period_s * std::sqrt(loop.hand_stiffness / mass);
    if (angle < 2) {  // not aliased
      EXPECT_LT(WorstError(loop, 0), 24 * kEpsilon) << i;
    }
  }
}

TEST(Discretize, OfAFreeMassIsTheDoubleIntegrator) {
  const LoopParameters loop = PerTick(0, 0, 1e-3, 0);
  const SampledPlant plant = Discretize(loop);
  EXPECT_EQ(plant.gain, 1e-6);
  EXPECT_EQ(plant.hold[0], 0.5);
  EXPECT_EQ(plant.hold[1], 0.5);
  EXPECT_EQ(plant.hold[2], 0);
  EXPECT_EQ(plant.static_gap, 0);
  EXPECT_EQ(plant.loss, 0);
}

TEST(Discretize, SplitsTheDelayIntoTicksAndAFraction) {
  const SampledPlant plant = Discretize(PerTick(0, 0, 1e-3, 2.25));
  EXPECT_EQ(plant.delay_ticks, 2);
  EXPECT_NEAR(plant.hold[0], 0.75 * 0.75 / 2, 1e-15);
  EXPECT_NEAR(plant.hold[2], 0.25 * 0.25 / 2, 1e-15);
  EXPECT_NEAR(plant.hold[0] + plant.hold[1] + plant.hold[2], 1, 1e-15);
}

TEST(Discretize, TakesAWholeNumberOfPeriodsForThatHoweverItIsRounded) {
  for (int i = 1; i <= 1000; ++i) {
    for (int ticks = 0; ticks <= 3; ++ticks) {
      LoopParameters loop = PerTick(0.1, 0.01, 1e-5 * i, 0);
      loop.delay_s = 1e-5 * i * ticks;
      const SampledPlant plant = Discretize(loop);
      EXPECT_EQ(plant.delay_ticks, ticks);
      EXPECT_EQ(plant.hold[2], 0);
    }
  }
}

}  // namespace
}  // namespace mwidth::model
