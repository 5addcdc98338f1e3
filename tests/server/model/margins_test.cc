#include "server/model/margins.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "tests/server/model/model_loops.h"

namespace mwidth::model {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPi = std::numbers::pi;

LoopParameters Free() {
  LoopParameters loop = TableTwo();
  loop.hand_stiffness = loop.hand_damping = loop.device_damping = 0;
  return loop;
}

// Of a free mass without friction L = x (z + 1)/(z (z - a)) with x = M (1 - a)/(2 mu).
struct FreeLoop {
  double a;
  double x;
};

FreeLoop FreeLoopOf(const LoopParameters& loop, double mass) {
  const double gap = -std::expm1(-2 * kPi * loop.cutoff_hz * loop.period_s);
  return {.a = 1 - gap, .x = mass * gap / (2 * loop.device_mass)};
}

TEST(PhaseMargin, OfAFreeMassIsKnownInClosedForm) {
  const LoopParameters loop = Free();
  for (const double ratio : {1.5, 3.0, 10.0, 25.0, 32.0}) {
    const auto [a, x] = FreeLoopOf(loop, ratio * loop.device_mass);
    // |L| = 1: x^2 (2 + 2 cos t) = 1 + a^2 - 2 a cos t
    const double t = std::acos((1 + a * a - 2 * x * x) / (2 * x * x + 2 * a));
    const double lag = t / 2 + std::atan2(std::sin(t), std::cos(t) - a);
    const Margin margin = ComputeMargins(loop, ratio * loop.device_mass).phase_rad;
    EXPECT_NEAR(margin.value, kPi - lag, 1e-12) << ratio;
    EXPECT_NEAR(margin.critical_hz, t / (2 * kPi * loop.period_s), 1e-9) << ratio;
  }
  // A lighter one than the device never reaches |L| = 1.
  EXPECT_EQ(ComputeMargins(loop, 0.9 * loop.device_mass).phase_rad.value, kInfinity);
  EXPECT_EQ(ComputeMargins(loop, 0.9 * loop.device_mass).phase_rad.critical_hz, 0);
}

TEST(ModulusMargin, OfAFreeMassIsKnownInClosedForm) {
  const LoopParameters loop = Free();
  for (const double ratio : {-0.95, -0.4, 1.5, 10.0, 25.0, 32.0}) {
    const auto [a, x] = FreeLoopOf(loop, ratio * loop.device_mass);
    // |1 + L|^2 = (A + B y + 4 x y^2)/(D - 2 a y) in y = cos t, least at its ends or where its slope is 0.
    const double p = x - a;
    const double constant = 1 + p * p + x * x - 2 * x;
    const double linear = 2 * p * (1 + x);
    const double d = 1 + a * a;
    const auto squared = [&](double y) { return (constant + linear * y + 4 * x * y * y) / (d - 2 * a * y); };
    double expected = std::fmin(squared(-1), squared(1));
    const double root = std::sqrt(d * d * x * x * 64 + 32 * a * x * (linear * d + 2 * a * constant));
    for (const double sign : {-1.0, 1.0}) {
      const double y = (8 * x * d + sign * root) / (16 * a * x);
      if (std::abs(y) < 1) {
        expected = std::fmin(expected, squared(y));
      }
    }
    EXPECT_NEAR(ComputeMargins(loop, ratio * loop.device_mass).modulus.value, std::sqrt(expected), 1e-11)
        << ratio;
  }
}

TEST(Margins, OfAFreeNegativeMassBindAtStandstill) {
  const LoopParameters loop = Free();
  const Margins margins = ComputeMargins(loop, -0.75 * loop.device_mass);
  EXPECT_NEAR(margins.gain.value, 4.0 / 3, 1e-14);
  EXPECT_EQ(margins.gain.critical_hz, 0);
  EXPECT_NEAR(margins.modulus.value, 0.25, 1e-14);
  EXPECT_EQ(margins.modulus.critical_hz, 0);
}

TEST(Margins, OfNoMassAreInfiniteAndItsModulusMarginIsOne) {
  const Margins margins = ComputeMargins(TableTwo(), 0);
  EXPECT_TRUE(margins.stable);
  EXPECT_EQ(margins.gain.value, kInfinity);
  EXPECT_EQ(margins.phase_rad.value, kInfinity);
  EXPECT_EQ(margins.delay.seconds, kInfinity);
  EXPECT_FALSE(margins.delay.at_least);
  EXPECT_EQ(margins.modulus.value, 1);
}

void ExpectNothingLeft(const Margins& margins) {
  EXPECT_FALSE(margins.stable);
  EXPECT_EQ(margins.phase_rad.value, 0);
  EXPECT_EQ(margins.delay.seconds, 0);
  EXPECT_FALSE(margins.delay.at_least);
  EXPECT_EQ(margins.modulus.value, 0);
}

TEST(Margins, OfAnUnstableMassAreUsedUpAndItsGainMarginLeadsBackToTheEdge) {
  const MWidth m_width = ComputeMWidth(TableTwo());
  for (const Edge& edge : {m_width.lower, m_width.upper}) {
    const Margins margins = ComputeMargins(TableTwo(), 2 * edge.mass);
    ExpectNothingLeft(margins);
    EXPECT_NEAR(margins.gain.value, 0.5, 1e-15);
    EXPECT_EQ(margins.gain.critical_hz, edge.critical_hz);
    ExpectNothingLeft(ComputeMargins(TableTwo(), edge.mass));
  }
}

TEST(Margins, AreNoneWhereTheMWidthIsEmpty) {
  LoopParameters loop = TableTwo();
  loop.hand_damping = loop.device_damping = 0;
  for (const double mass : {0.0, 0.1}) {
    const Margins margins = ComputeMargins(loop, mass);
    ExpectNothingLeft(margins);
    EXPECT_EQ(margins.gain.value, 0);
    EXPECT_EQ(margins.gain.critical_hz, 0);
  }
}

TEST(Margins, VanishTowardsTheEdges) {
  const MWidth m_width = ComputeMWidth(TableTwo());
  for (const Edge& edge : {m_width.lower, m_width.upper}) {
    for (const double gap : {1e-3, 1e-6, 1e-9, 1e-12}) {
      const Margins margins = ComputeMargins(TableTwo(), edge.mass * (1 - gap));
      EXPECT_TRUE(margins.stable);
      EXPECT_NEAR(margins.gain.value, 1 + gap, 2 * gap * gap + 1e-15);
      EXPECT_LE(margins.modulus.value, gap * (1 + 1e-3));
      EXPECT_GT(margins.modulus.value, gap / 10);
      EXPECT_NEAR(margins.modulus.critical_hz, edge.critical_hz, 2 * gap * edge.critical_hz + 1e-6);
      EXPECT_LT(margins.phase_rad.value, 20 * gap);
      EXPECT_GE(2 * std::sin(margins.phase_rad.value / 2), margins.modulus.value * (1 - 1e-3));
    }
  }
  // The positive side loses its delay margin too; the negative one has phase to spend where delay helps it.
  EXPECT_LT(ComputeMargins(TableTwo(), m_width.upper.mass * (1 - 1e-6)).delay.seconds, 1e-8);
}

TEST(Margins, TellOfAnEdgeAtHalfTheSampleRateByModulusAlone) {
  // A stiff loop without a filter to speak of; its upper edge is at z = -1.
  LoopParameters loop = TableTwo();
  loop.hand_damping = 100;
  loop.cutoff_hz = 480;
  loop.delay_s = loop.period_s / 2;
  const Edge upper = ComputeMWidth(loop).upper;
  const Margins margins = ComputeMargins(loop, upper.mass * (1 - 1e-6));
  SCOPED_TRACE(upper.critical_hz);
  EXPECT_LE(margins.modulus.value, 1.01e-6);
}

// No z in the filter's numerator is one tick of delay more.
TEST(Margins, KnowAnyRationalEstimator) {
  const LoopParameters loop = TableTwo();
  LoopParameters later = loop;
  later.delay_s = loop.period_s;
  LinearEstimator late = EstimatorOf(loop);
  late.denominator = Multiply(late.denominator, {1, 1});
  const MWidth m_width = ComputeMWidth(later);
  for (const double mass : {-0.08, 0.3, 0.6, 0.9, 1.01}) {
    const Margins margins = ComputeMargins(loop, late, m_width, mass);
    const Margins expected = ComputeMargins(later, mass);
    ASSERT_TRUE(margins.stable);
    EXPECT_EQ(margins.gain.value, expected.gain.value);
    EXPECT_EQ(std::isinf(margins.phase_rad.value), std::isinf(expected.phase_rad.value));
    if (std::isfinite(expected.phase_rad.value)) {
      EXPECT_NEAR(margins.phase_rad.value, expected.phase_rad.value, 1e-12);
    }
    EXPECT_NEAR(margins.modulus.value, expected.modulus.value, 1e-12);
    if (!expected.delay.at_least) {
      EXPECT_NEAR(margins.delay.seconds, expected.delay.seconds, 1e-12 * loop.period_s);
    }
  }
}

TEST(Margins, RefuseAnEstimatorThatIsNone) {
  const LinearEstimator differentiator{.numerator = {0, 1}, .denominator = {1, 1}};
  EXPECT_THROW(ComputeMargins(TableTwo(), differentiator, ComputeMWidth(TableTwo()), 0.1),
               std::invalid_argument);
}

TEST(WorstMargins, TakeEachMarginFromTheLoopThatHasTheLeast) {
  RandomLoops random(31);
  std::vector<LoopParameters> loops;
  for (int i = 0; i < 12; ++i) {
    LoopParameters loop = TableTwo();
    loop.hand_stiffness = random.LogUniform(50, 5000);
    loop.hand_damping = random.LogUniform(1, 20);
    loop.delay_s = random.Uniform(0, 1e-3);
    loops.push_back(loop);
  }
  for (const double mass : {0.5, 0.8, -0.04}) {
    const WorstMargins worst = WorstMarginsAmong(loops, mass);
    for (std::size_t i = 0; i < loops.size(); ++i) {
      const Margins one = ComputeMargins(loops[i], mass);
      EXPECT_LE(worst.margins.gain.value, one.gain.value);
      EXPECT_LE(worst.margins.phase_rad.value, one.phase_rad.value);
      EXPECT_LE(worst.margins.delay.seconds, one.delay.seconds);
      EXPECT_LE(worst.margins.modulus.value, one.modulus.value);
    }
    EXPECT_EQ(worst.margins.gain.value, ComputeMargins(loops[worst.gain_loop], mass).gain.value);
    EXPECT_EQ(worst.margins.phase_rad.value, ComputeMargins(loops[worst.phase_loop], mass).phase_rad.value);
    EXPECT_EQ(worst.margins.delay.seconds, ComputeMargins(loops[worst.delay_loop], mass).delay.seconds);
    EXPECT_EQ(worst.margins.delay.at_least, ComputeMargins(loops[worst.delay_loop], mass).delay.at_least);
    EXPECT_EQ(worst.margins.modulus.value, ComputeMargins(loops[worst.modulus_loop], mass).modulus.value);
  }
}

TEST(WorstMargins, AreUsedUpWhereOneLoopIsUnstable) {
  LoopParameters light = TableTwo();
  light.device_mass = 0.001;
  const double mass = 2 * ComputeMWidth(light).upper.mass;
  const WorstMargins worst = WorstMarginsAmong(std::array{TableTwo(), light, TableTwo()}, mass);
  ExpectNothingLeft(worst.margins);
  EXPECT_NEAR(worst.margins.gain.value, 0.5, 1e-14);
  EXPECT_EQ(worst.gain_loop, 1U);
  EXPECT_EQ(worst.phase_loop, 1U);
  EXPECT_EQ(worst.delay_loop, 1U);
  EXPECT_EQ(worst.modulus_loop, 1U);
}

TEST(WorstMargins, OfNoLoopsAreRefused) { EXPECT_THROW(WorstMarginsAmong({}, 0.1), std::invalid_argument); }

}  // namespace
}  // namespace mwidth::model
