#include "server/model/m_width.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace mwidth::model {
namespace {

using ::testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Table II of the paper at 1 kHz with a cut-off of 10 Hz.
constexpr LoopParameters kPaper{.device_mass = 0.07,
                                .device_damping = 0.005,
                                .hand_mass = 0,
                                .hand_damping = 5,
                                .hand_stiffness = 700,
                                .period_s = 1e-3,
                                .cutoff_hz = 10,
                                .delay_s = 0};

void ExpectRelative(double actual, double expected, double relative) {
  EXPECT_NEAR(actual, expected, std::abs(expected) * relative);
}

TEST(MWidth, OfThePapersLoopAt1KilohertzReaches34TimesTheDeviceMass) {
  const MWidth m_width = ComputeMWidth(kPaper);
  ASSERT_FALSE(m_width.empty());
  EXPECT_NEAR(m_width.lower.mass / 0.07, -1.3981549, 5e-8);
  EXPECT_NEAR(m_width.upper.mass / 0.07, 34.2468304, 5e-8);
}

TEST(MWidth, NarrowsAt500HertzWithACutoffOf30Hertz) {
  LoopParameters loop = kPaper;
  loop.period_s = 2e-3;
  loop.cutoff_hz = 30;
  const MWidth m_width = ComputeMWidth(loop);
  EXPECT_NEAR(m_width.lower.mass / 0.07, -0.8516775, 5e-8);
  EXPECT_NEAR(m_width.upper.mass / 0.07, 6.7990892, 5e-8);
}

TEST(MWidth, HalvesItsUpperSideWithOneTickOfDelay) {
  LoopParameters loop = kPaper;
  loop.delay_s = 1e-3;
  EXPECT_NEAR(ComputeMWidth(loop).upper.mass / 0.07, 14.5212851, 5e-8);
}

TEST(MWidth, LosesATickWithoutTheZInTheFiltersNumerator) {
  for (const double delay_ticks : {0.0, 0.6, 2.0}) {
    LoopParameters late = kPaper;
    late.estimator = EstimatorKind::kLateFilteredDifference;
    late.delay_s = delay_ticks * late.period_s;
    LoopParameters delayed = kPaper;
    delayed.delay_s = (delay_ticks + 1) * late.period_s;
    ExpectRelative(ComputeMWidth(late).upper.mass, ComputeMWidth(delayed).upper.mass, 1e-14);
    ExpectRelative(ComputeMWidth(late).lower.mass, ComputeMWidth(delayed).lower.mass, 1e-14);
  }
  LoopParameters late = kPaper;
  late.estimator = EstimatorKind::kLateFilteredDifference;
  EXPECT_NEAR(ComputeMWidth(late).upper.mass / 0.07, 14.5212851, 5e-8);
}

TEST(MWidth, DependsOnTheEstimator) {
  LoopParameters loop = kPaper;
  loop.estimator = EstimatorKind::kButterworth;
  EXPECT_NEAR(ComputeMWidth(loop).lower.mass / 0.07, -1.9664782, 5e-8);
  EXPECT_NEAR(ComputeMWidth(loop).upper.mass / 0.07, 27.1096044, 5e-8);
  loop.estimator = EstimatorKind::kKalman;
  EXPECT_NEAR(ComputeMWidth(loop).lower.mass / 0.07, -2.6063710, 5e-8);
  EXPECT_NEAR(ComputeMWidth(loop).upper.mass / 0.07, 10.0464288, 5e-8);
}

TEST(MWidth, NamesTheFrequencyAtWhichTheLoopOscillates) {
  const MWidth m_width = ComputeMWidth(kPaper);
  // The hand's resonance is at sqrt(700 / 0.07) = 100 rad/s = 15.9 Hz; the light side oscillates just above
  // it.
  EXPECT_NEAR(m_width.lower.critical_hz, 18.368534, 1e-6);
  EXPECT_NEAR(m_width.upper.critical_hz, 261.9771, 1e-4);
}

TEST(MWidth, IsContinuousInTheDelay) {
  for (const double ticks : {0.0, 0.5, 1.0, 2.0, 2.5, 3.0}) {
    LoopParameters loop = kPaper;
    loop.delay_s = ticks * loop.period_s;
    const MWidth at = ComputeMWidth(loop);
    for (const double shift : {-1e-12, 1e-12}) {
      LoopParameters near = loop;
      near.delay_s = std::fmin(std::fmax(loop.delay_s + shift * loop.period_s, 0), 3 * loop.period_s);
      const MWidth shifted = ComputeMWidth(near);
      ExpectRelative(shifted.lower.mass, at.lower.mass, 1e-11);
      ExpectRelative(shifted.upper.mass, at.upper.mass, 1e-11);
    }
  }
}

TEST(MWidth, OfAReleasedFrictionlessMassIsKnownInClosedForm) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> exponent(-1, 1);
  for (int i = 0; i < 1000; ++i) {
    const double mass = std::pow(100, exponent(random));
    const double period_s = std::pow(30, exponent(random)) * 3.2e-4;
    const double cutoff_hz = 0.5 / period_s * std::pow(1e-4, 0.5 + 0.5 * exponent(random));
    const MWidth m_width = ComputeMWidth({.device_mass = mass,
                                          .device_damping = 0,
                                          .hand_mass = 0,
                                          .hand_damping = 0,
                                          .hand_stiffness = 0,
                                          .period_s = period_s,
                                          .cutoff_hz = cutoff_hz,
                                          .delay_s = 0});
    const double one_less_a = -std::expm1(-2 * std::numbers::pi * cutoff_hz * period_s);
    ASSERT_FALSE(m_width.empty());
    EXPECT_EQ(m_width.lower.mass, -mass);
    EXPECT_EQ(m_width.lower.critical_hz, 0);
    ExpectRelative(m_width.upper.mass, 2 * mass / one_less_a, 1e-15);
  }
}

TEST(MWidth, OfANearlyFreeMassTendsToThatOfTheFreeOne) {
  for (const double delay_ticks : {0.0, 0.7, 2.0}) {
    LoopParameters loop = kPaper;
    loop.hand_stiffness = loop.hand_damping = loop.device_damping = 0;
    loop.delay_s = delay_ticks * loop.period_s;
    const MWidth free = ComputeMWidth(loop);
    loop.device_damping = 1e-13;
    const MWidth nearly = ComputeMWidth(loop);
    ExpectRelative(nearly.lower.mass, free.lower.mass, 1e-12);
    ExpectRelative(nearly.upper.mass, free.upper.mass, 1e-12);
  }
}

TEST(MWidth, CountsTheHandsMassAsTheDevices) {
  LoopParameters loop = kPaper;
  loop.device_mass = 0.03;
  loop.hand_mass = 0.04;
  ExpectRelative(ComputeMWidth(loop).upper.mass, ComputeMWidth(kPaper).upper.mass, 1e-14);
}

TEST(MWidth, IsEmptyForASpringWithoutDampingAndSaysSo) {
  LoopParameters loop = kPaper;
  loop.device_damping = loop.hand_damping = 0;
  const MWidth m_width = ComputeMWidth(loop);
  EXPECT_TRUE(m_width.empty());
  EXPECT_THAT(m_width.empty_reason, HasSubstr("without damping"));
  EXPECT_FALSE(m_width.Contains(0));
}

TEST(MWidth, ContainsWhatLiesStrictlyInside) {
  const MWidth m_width = ComputeMWidth(kPaper);
  EXPECT_TRUE(m_width.Contains(0));
  EXPECT_TRUE(m_width.Contains(m_width.upper.mass * 0.999));
  EXPECT_TRUE(m_width.Contains(m_width.lower.mass * 0.999));
  EXPECT_FALSE(m_width.Contains(m_width.upper.mass));
  EXPECT_FALSE(m_width.Contains(m_width.lower.mass));
  EXPECT_FALSE(m_width.Contains(std::numeric_limits<double>::quiet_NaN()));
}

TEST(GainMargin, IsTheFactorToTheEdgeOnTheMasssSide) {
  const MWidth m_width = ComputeMWidth(kPaper);
  ExpectRelative(GainMargin(m_width, m_width.upper.mass / 4), 4, 1e-15);
  ExpectRelative(GainMargin(m_width, m_width.lower.mass * 2), 0.5, 1e-15);
  EXPECT_EQ(GainMargin(m_width, 0), kInfinity);
}

TEST(GainMargin, IsNoneWhereNothingIsStable) {
  LoopParameters loop = kPaper;
  loop.device_damping = loop.hand_damping = 0;
  EXPECT_EQ(GainMargin(ComputeMWidth(loop), 0), 0);
  EXPECT_EQ(GainMargin(ComputeMWidth(kPaper), std::numeric_limits<double>::quiet_NaN()), 0);
}

TEST(HighestAdmittingCutoff, IsTheRunningOneForAnAdmittedMass) {
  EXPECT_EQ(HighestAdmittingCutoffHz(kPaper, 0.5, 2), kPaper.cutoff_hz);
}

TEST(HighestAdmittingCutoff, LiesJustBelowTheCutoffWhoseEdgeIsTheMass) {
  for (const double mass : {4.0, 10.0, -0.12, -0.2}) {
    for (const double gain_margin : {1.0, std::sqrt(2.0)}) {
      const auto cutoff_hz = HighestAdmittingCutoffHz(kPaper, mass, gain_margin);
      ASSERT_TRUE(cutoff_hz.has_value()) << mass;
      LoopParameters loop = kPaper;
      loop.cutoff_hz = *cutoff_hz;
      EXPECT_TRUE(ComputeMWidth(loop).Contains(mass * gain_margin));
      loop.cutoff_hz = *cutoff_hz * (1 + 1e-6);
      EXPECT_FALSE(ComputeMWidth(loop).Contains(mass * gain_margin));
      // Nothing above is admitted either.
      for (int i = 1; i <= 2000; ++i) {
        loop.cutoff_hz = *cutoff_hz + (kPaper.cutoff_hz - *cutoff_hz) * i / 2000;
        ASSERT_FALSE(ComputeMWidth(loop).Contains(mass * gain_margin)) << loop.cutoff_hz;
      }
    }
  }
}

TEST(HighestAdmittingCutoff, IsNoneForAMassThatNoFilterStabilizes) {
  EXPECT_FALSE(HighestAdmittingCutoffHz(kPaper, 1e4, 1).has_value());
  EXPECT_FALSE(HighestAdmittingCutoffHz(kPaper, kInfinity, 1).has_value());
  EXPECT_FALSE(HighestAdmittingCutoffHz(kPaper, std::numeric_limits<double>::quiet_NaN(), 1).has_value());
  LoopParameters free = kPaper;
  free.hand_stiffness = free.hand_damping = free.device_damping = 0;
  EXPECT_FALSE(HighestAdmittingCutoffHz(free, -0.08, 1).has_value());
}

}  // namespace
}  // namespace mwidth::model
