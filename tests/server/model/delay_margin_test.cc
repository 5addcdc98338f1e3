#include "server/model/delay_margin.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>

#include "server/model/frequency_response.h"
#include "server/model/m_width.h"
#include "tests/server/model/closed_loop.h"
#include "tests/server/model/closed_loop_map.h"
#include "tests/server/model/model_loops.h"

namespace mwidth::model {
namespace {

LoopParameters Later(LoopParameters loop, double seconds) {
  loop.delay_s += seconds;
  return loop;
}

double Range(const LoopParameters& loop) { return 3 * loop.period_s - loop.delay_s; }

bool IsStable(const LoopParameters& loop, double mass) {
  return IsStableByJury(ClosedLoop(loop).Characteristic(mass));
}

TEST(DelayMargin, IsTheDelayAtWhoseEdgeTheMassLies) {
  LoopParameters free = TableTwo();
  free.hand_stiffness = free.hand_damping = free.device_damping = 0;
  LoopParameters released = TableTwo();
  released.hand_stiffness = 0;
  for (const LoopParameters& loop : {TableTwo(), released, free}) {
    for (const double ticks : {0.01, 0.3, 1.0, 1.7, 2.0, 2.5}) {
      const Edge edge = ComputeMWidth(Later(loop, ticks * loop.period_s)).upper;
      const DelayMargin margin = ComputeMargins(loop, edge.mass).delay;
      EXPECT_NEAR(margin.seconds, ticks * loop.period_s, 1e-12 * loop.period_s) << ticks;
      EXPECT_NEAR(margin.critical_hz, edge.critical_hz, 1e-8) << ticks;
      EXPECT_FALSE(margin.at_least);
    }
  }
}

TEST(DelayMargin, SeparatesMotionThatDecaysFromMotionThatGrows) {
  for (const double mass : {0.95, 1.0, 1.5, 2.0, 2.3}) {
    const LoopParameters loop = TableTwo();
    const DelayMargin margin = ComputeMargins(loop, mass).delay;
    ASSERT_FALSE(margin.at_least);
    uint64_t ticks = 0;
    EXPECT_EQ(ClosedLoopMap(Later(loop, 0.999 * margin.seconds), mass).Prove(ticks), Verdict::kDecays)
        << mass;
    EXPECT_EQ(ClosedLoopMap(Later(loop, 1.001 * margin.seconds), mass).Prove(ticks), Verdict::kGrows) << mass;
  }
}

TEST(DelayMargin, KeepsEverySmallerMassStableUntilItIsUsedUp) {
  RandomLoops random(51);
  int finite = 0;
  for (int i = 0; i < 400; ++i) {
    LoopParameters loop = random.Next();
    loop.estimator = kEstimatorKinds.at(static_cast<std::size_t>(i) % kEstimatorKinds.size());
    const MWidth m_width = ComputeMWidth(loop);
    const double edge = random.Uniform(0, 1) < 0.5 ? m_width.lower.mass : m_width.upper.mass;
    const double mass = edge * (1 - random.LogUniform(1e-3, 1));
    const DelayMargin margin = ComputeMargins(loop, mass).delay;
    const double until = std::min(margin.seconds, Range(loop));
    for (const double share : {0.1, 0.4, 0.7, 0.9, 0.999}) {
      for (const double smaller : {0.3, 0.9, 1.0}) {
        ASSERT_TRUE(IsStable(Later(loop, share * until), smaller * mass))
            << i << ' ' << share << ' ' << smaller;
      }
    }
    if (margin.at_least || 1.001 * margin.seconds > Range(loop)) {
      continue;
    }
    ++finite;
    const LoopParameters after = Later(loop, 1.001 * margin.seconds);
    const MWidth narrower = ComputeMWidth(after);
    EXPECT_FALSE(narrower.Contains(mass)) << i;
    // The mass itself is unstable, or one on the way to it.
    const double new_edge = mass > 0 ? narrower.upper.mass : narrower.lower.mass;
    EXPECT_TRUE(!IsStable(after, mass) || !IsStable(after, new_edge * (1 + 1e-6))) << i;
  }
  EXPECT_GT(finite, 100);
}

TEST(DelayMargin, IsNeverPassedByTheMWidth) {
  RandomLoops random(52);
  for (int i = 0; i < 1000; ++i) {
    LoopParameters loop = random.Next();
    loop.estimator = kEstimatorKinds.at(static_cast<std::size_t>(i) % kEstimatorKinds.size());
    const MWidth m_width = ComputeMWidth(loop);
    const double edge = random.Uniform(0, 1) < 0.5 ? m_width.lower.mass : m_width.upper.mass;
    const double mass = edge * (1 - random.LogUniform(1e-3, 1));
    const DelayMargin margin = ComputeMargins(loop, mass).delay;
    EXPECT_LE(margin.critical_hz, 0.5 / loop.period_s * (1 + 1e-15)) << i;
    const double until = std::min(margin.seconds, Range(loop));
    for (int k = 0; k < 50; ++k) {
      ASSERT_TRUE(ComputeMWidth(Later(loop, until * k / 50)).Contains(mass)) << i << ' ' << k;
    }
    // Rounding of the delay itself, as a share of it, is what limits a short margin.
    const double short_of = std::max(1e-9 * until, 1e-12 * loop.period_s);
    EXPECT_TRUE(ComputeMWidth(Later(loop, until - short_of)).Contains(mass)) << i;
  }
}

TEST(DelayMargin, EndsWhereSmallerMassesAreLostFirst) {
  // Light, stiff and slowly sampled: near half a tick of delay the lower edge leaps from twice this mass to a
  // third of it. The mass itself would be stable for a little longer, but no ramp leads there or back.
  const LoopParameters loop{.device_mass = 0.00134,
                            .device_damping = 0.00036,
                            .hand_mass = 0.02318,
                            .hand_damping = 0.1099,
                            .hand_stiffness = 17190,
                            .period_s = 0.003908,
                            .cutoff_hz = 10.72};
  constexpr double kMass = -0.4237;
  const double margin_s = ComputeMargins(loop, kMass).delay.seconds;
  EXPECT_LT(ComputeMWidth(Later(loop, margin_s * (1 - 1e-9))).lower.mass, 2 * kMass);
  EXPECT_GT(ComputeMWidth(Later(loop, margin_s * (1 + 1e-9))).lower.mass, 0.4 * kMass);
  EXPECT_TRUE(IsStable(Later(loop, margin_s * 1.001), kMass));
  EXPECT_FALSE(IsStable(Later(loop, margin_s * 1.001), 0.4 * kMass));
}

TEST(DelayMargin, IsALowerBoundWhereTheSupportedRangeEnds) {
  const DelayMargin margin = ComputeMargins(TableTwo(), 0.2).delay;
  EXPECT_TRUE(margin.at_least);
  EXPECT_GE(margin.seconds, 3e-3);
  EXPECT_EQ(margin.critical_hz, 0);
  EXPECT_TRUE(ComputeMWidth(Later(TableTwo(), 3e-3)).Contains(0.2));
}

// Damped to a halt within a tick: the upper edge, at half the sample rate, falls and rises twice over the
// supported range of delay.
constexpr LoopParameters kHalted{.device_mass = 0.003,
                                 .device_damping = 0,
                                 .hand_mass = 0.011,
                                 .hand_damping = 70.5,
                                 .hand_stiffness = 119,
                                 .period_s = 0.0085,
                                 .cutoff_hz = 35};

TEST(DelayMargin, MayBindAtHalfTheSampleRate) {
  const double period_s = kHalted.period_s;
  const double mass = ComputeMWidth(Later(kHalted, 1.9 * period_s)).upper.mass;
  const DelayMargin margin = ComputeMargins(Later(kHalted, 1.2 * period_s), mass).delay;
  EXPECT_FALSE(margin.at_least);
  EXPECT_NEAR(margin.seconds, 0.7 * period_s, 1e-11 * period_s);
  EXPECT_NEAR(margin.critical_hz, 0.5 / period_s, 1e-9);
}

TEST(DelayMargin, PassesAnEdgeThatComesNearAndTurnsBack) {
  double turn_s = 0;
  double narrowest = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= 20000; ++i) {
    const double later_s = (1.8 + 0.4 * i / 20000) * kHalted.period_s;
    const double edge = ComputeMWidth(Later(kHalted, later_s)).upper.mass;
    if (edge < narrowest) {
      narrowest = edge;
      turn_s = later_s;
    }
  }
  EXPECT_NEAR(turn_s, 2 * kHalted.period_s, 0.1 * kHalted.period_s);
  EXPECT_GT(ComputeMargins(kHalted, narrowest * (1 - 1e-4)).delay.seconds, 2.2 * kHalted.period_s);
  // So near that no step is long enough: but no crossing is claimed where there is none.
  for (const double gap : {2e-5, 1e-5, 5e-6}) {
    const DelayMargin margin = ComputeMargins(kHalted, narrowest * (1 - gap)).delay;
    EXPECT_TRUE(margin.at_least || margin.seconds > 2.2 * kHalted.period_s) << gap;
  }
  const DelayMargin margin = ComputeMargins(kHalted, narrowest * (1 + 1e-4)).delay;
  EXPECT_LT(margin.seconds, turn_s);
  EXPECT_GT(margin.seconds, 1.8 * kHalted.period_s);
}

TEST(DelayMargin, ClaimsNothingWhereTheResonanceIsSharperThanDoublePrecision) {
  LoopParameters loop = TableTwo();
  loop.device_damping = 2e-8;
  loop.hand_damping = 0;
  const double damped = 0.9 * ComputeMWidth(loop).lower.mass;
  EXPECT_GT(ComputeMargins(loop, damped).delay.seconds, 0);
  loop.device_damping = 1e-9;
  const DelayMargin margin = ComputeMargins(loop, 0.9 * ComputeMWidth(loop).lower.mass).delay;
  EXPECT_EQ(margin.seconds, 0);
  EXPECT_TRUE(margin.at_least);
}

TEST(DelayMargin, IsThePhaseOverTheFrequencyForWholeTicksAlone) {
  for (const double ticks : {0.5, 1.0, 1.5, 2.0, 2.4}) {
    const LoopParameters loop = TableTwo();
    const double mass = ComputeMWidth(Later(loop, ticks * loop.period_s)).upper.mass;
    const DelayMargin margin = ComputeMargins(loop, mass).delay;
    const std::complex<double> open = SampledResponse(loop).Loop(mass, margin.critical_hz);
    const double continuous = std::arg(-open) / (2 * std::numbers::pi * margin.critical_hz);
    if (ticks == std::floor(ticks)) {
      EXPECT_NEAR(std::abs(open), 1, 1e-10);
      EXPECT_NEAR(continuous, margin.seconds, 1e-12 * loop.period_s);
    } else {
      EXPECT_GT(std::abs(std::abs(open) - 1), 1e-4) << ticks;
    }
  }
}

}  // namespace
}  // namespace mwidth::model
