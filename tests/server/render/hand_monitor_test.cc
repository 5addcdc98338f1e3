#include "server/render/hand_monitor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace mwidth::render {
namespace {

using Kind = HandVerdict::Kind;

constexpr double kPeriodS = 1e-3;
constexpr double kForceLimit = 10;
constexpr double kMass = -0.2;
constexpr double kCriticalHz = 5;
constexpr HandMonitorConfig kConfig{.device_mass = 0.2, .device_damping = 0.1, .least_damping = 1};

// An oscillation of the velocity, v = e^(st), and a force that puts `put_in` v^2 into it.
struct Oscillation {
  double frequency_hz = kCriticalHz;
  // In one period.
  double growth = 1;
  double put_in = 0.9;
  // At first; 0.1 m/s at 5 Hz swings the force by 2 * 0.2 kg * 31/s * 0.1 m/s = 1.26 N.
  double amplitude = 0.1;
  // A reach under way.
  double mean_velocity = 0;

  double VelocityAt(double time_s) const {
    return mean_velocity + amplitude * std::pow(growth, time_s * frequency_hz) *
                               std::sin(2 * std::numbers::pi * frequency_hz * time_s);
  }
  HandObservation At(uint64_t tick, double mass = kMass) const {
    const double velocity = VelocityAt(static_cast<double>(tick) * kPeriodS);
    return {.velocity = velocity, .force = -put_in * (velocity - mean_velocity), .mass = mass, .periods = 1};
  }
};

class HandMonitorTest : public testing::Test {
 protected:
  explicit HandMonitorTest(const HandMonitorConfig& config = kConfig)
      : monitor(config, kPeriodS, kForceLimit) {
    monitor.SetCriticalHz(kCriticalHz);
  }
  // Until the first verdict other than kCertified, or for `periods` of the oscillation.
  HandVerdict Watch(const Oscillation& oscillation, double periods = 8, double mass = kMass) {
    const auto ticks = static_cast<uint64_t>(periods / oscillation.frequency_hz / kPeriodS);
    for (tick = 0; tick < ticks; ++tick) {
      const HandVerdict verdict = monitor.Step(oscillation.At(tick, mass));
      if (verdict.kind != Kind::kCertified) {
        return verdict;
      }
    }
    return {};
  }
  double PeriodsPassed(const Oscillation& oscillation) const {
    return static_cast<double>(tick) * kPeriodS * oscillation.frequency_hz;
  }

  HandMonitor monitor;
  uint64_t tick = 0;
};

TEST_F(HandMonitorTest, TellsAGrowingOscillationWithinThreePeriods) {
  for (const double growth : {1.1, 1.25, 1.45}) {
    const Oscillation oscillation{.growth = growth};
    const HandVerdict verdict = Watch(oscillation);
    ASSERT_EQ(verdict.kind, Kind::kGrowingOscillation) << growth;
    EXPECT_NEAR(verdict.value, growth, 0.05 * growth);
    EXPECT_EQ(verdict.limit, kConfig.min_growth);
    EXPECT_NEAR(verdict.frequency_hz, kCriticalHz, 0.05 * kCriticalHz);
    EXPECT_LT(PeriodsPassed(oscillation), 3);
    monitor.Forget();
  }
}

TEST_F(HandMonitorTest, TellsItUnderAReachToo) {
  EXPECT_EQ(Watch({.growth = 1.5, .mean_velocity = 0.5}).kind, Kind::kGrowingOscillation);
}

TEST_F(HandMonitorTest, TellsSofterAndStifferHandsThanTheCertifiedOne) {
  for (const double share : {0.4, 0.7, 1.5, 2.8}) {
    monitor.Forget();
    EXPECT_EQ(Watch({.frequency_hz = share * kCriticalHz, .growth = 1.2, .amplitude = 0.15}).kind,
              Kind::kGrowingOscillation)
        << share;
  }
}

TEST_F(HandMonitorTest, LeavesADecayingOscillationAlone) {
  for (const double growth : {0.2, 0.5, 0.9, 0.98}) {
    monitor.Forget();
    EXPECT_EQ(Watch({.growth = growth}).kind, Kind::kCertified) << growth;
  }
}

TEST_F(HandMonitorTest, LeavesGrowthAloneThatOnlyTheHandCanHaveFed) {
  // The force takes energy out.
  EXPECT_EQ(Watch({.growth = 1.5, .put_in = -0.1}).kind, Kind::kCertified);
  monitor.Forget();
  // What the force puts in is less than what the kinetic energy grows by: 0.2 kg * 2 ln(2) * 5 Hz = 1.39 N
  // s/m.
  EXPECT_EQ(Watch({.growth = 1.8, .put_in = 0.9}, 3).kind, Kind::kCertified);
  monitor.Forget();
  EXPECT_EQ(Watch({.growth = 1.8, .put_in = 1.4, .amplitude = 0.05}).kind, Kind::kGrowingOscillation);
}

TEST_F(HandMonitorTest, TellsAForceThatPutsInMoreThanTheLeastDampingTakesOut) {
  const Oscillation oscillation{.growth = 0.95, .put_in = 1.3, .amplitude = 0.6};
  const HandVerdict verdict = Watch(oscillation);
  ASSERT_EQ(verdict.kind, Kind::kEnergyExcess);
  EXPECT_NEAR(verdict.value, 1.3, 1e-6);
  EXPECT_DOUBLE_EQ(verdict.limit, 1.2);
  EXPECT_LT(PeriodsPassed(oscillation), 3);
  EXPECT_GE(verdict.swing, kConfig.energy_swing * kForceLimit);
}

TEST_F(HandMonitorTest, LeavesLessEnergyAndSmallerSwingsAlone) {
  EXPECT_EQ(Watch({.growth = 0.95, .put_in = 1.1, .amplitude = 0.6}).kind, Kind::kCertified);
  monitor.Forget();
  // 2.5 N, 25 % of the limit.
  EXPECT_EQ(Watch({.growth = 0.95, .put_in = 1.3, .amplitude = 0.2}).kind, Kind::kCertified);
}

TEST_F(HandMonitorTest, LeavesAnOscillationAloneThatIsSmall) {
  EXPECT_EQ(Watch({.growth = 1.1, .amplitude = 0.01}, 8).kind, Kind::kCertified);
  EXPECT_EQ(Watch({.growth = 1.1, .amplitude = 0.01}, 60).kind, Kind::kGrowingOscillation);
}

TEST_F(HandMonitorTest, LeavesFrequenciesAloneThatNoCertifiedMassHas) {
  for (const double share : {0.2, 4.0}) {
    monitor.Forget();
    EXPECT_EQ(Watch({.frequency_hz = share * kCriticalHz, .growth = 1.2, .put_in = 2}).kind, Kind::kCertified)
        << share;
  }
}

TEST_F(HandMonitorTest, WatchesNegativeMassesOnly) {
  EXPECT_EQ(Watch({.growth = 1.5}, 8, 0).kind, Kind::kCertified);
  EXPECT_EQ(Watch({.growth = 1.5}, 8, -kMass).kind, Kind::kCertified);
}

TEST_F(HandMonitorTest, WatchesNothingWithoutACriticalFrequency) {
  monitor.SetCriticalHz(0);
  EXPECT_EQ(Watch({.growth = 1.5}).kind, Kind::kCertified);
}

TEST_F(HandMonitorTest, BeginsAnewWithAnotherCriticalFrequencyAndAfterAVerdict) {
  ASSERT_EQ(Watch({.growth = 1.5}).kind, Kind::kGrowingOscillation);
  const uint64_t first = tick;
  ASSERT_EQ(Watch({.growth = 1.5}).kind, Kind::kGrowingOscillation);
  EXPECT_EQ(tick, first);
  // Half-way to the verdict.
  const Oscillation oscillation{.growth = 1.5};
  for (tick = 0; tick < first / 2; ++tick) {
    monitor.Step(oscillation.At(tick));
  }
  monitor.SetCriticalHz(2 * kCriticalHz);
  monitor.SetCriticalHz(kCriticalHz);
  ASSERT_EQ(Watch(oscillation).kind, Kind::kGrowingOscillation);
  EXPECT_EQ(tick, first);
}

TEST_F(HandMonitorTest, BridgesShortGapsAndBeginsAnewAfterLongOnes) {
  const Oscillation oscillation{.growth = 1.5};
  for (const uint64_t gap : {uint64_t{5}, HandMonitor::kLongestGap}) {
    monitor.Forget();
    HandVerdict verdict;
    for (tick = 0; tick < 1600 && verdict.kind == Kind::kCertified; tick += gap) {
      HandObservation seen = oscillation.At(tick);
      seen.periods = gap;
      verdict = monitor.Step(seen);
    }
    EXPECT_EQ(verdict.kind, Kind::kGrowingOscillation) << gap;
  }
  monitor.Forget();
  for (tick = 0; tick < 1600; tick += HandMonitor::kLongestGap + 1) {
    HandObservation seen = oscillation.At(tick);
    seen.periods = HandMonitor::kLongestGap + 1;
    EXPECT_EQ(monitor.Step(seen).kind, Kind::kCertified);
  }
}

class DisabledHandMonitorTest : public HandMonitorTest {
 protected:
  DisabledHandMonitorTest() : HandMonitorTest({.enabled = false}) {}
};

TEST_F(DisabledHandMonitorTest, LeavesEverythingAlone) {
  EXPECT_EQ(Watch({.growth = 1.5, .put_in = 5, .amplitude = 1}).kind, Kind::kCertified);
}

}  // namespace
}  // namespace mwidth::render
