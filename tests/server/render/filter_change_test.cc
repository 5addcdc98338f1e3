// Another filter for a loop that runs: never under a mass that it was not admitted for, never with a jump.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "server/model/m_width.h"
#include "tests/server/render/axis.h"

namespace mwidth::render {
namespace {

using exchange::Fault;
using exchange::Filter;
using exchange::Sample;
using exchange::State;
using model::EstimatorKind;

Filter FilterOf(EstimatorKind kind, double cutoff_hz) {
  return {.estimator = static_cast<uint8_t>(kind), .cutoff_hz = cutoff_hz};
}

constexpr int kRampTicks = 200;  // kFilterRampS at 1 kHz

void SetFilter(Axis& axis, const Filter& filter) {
  axis.settings.filter = filter;
  axis.Post();
}

TEST(FilterChangeTest, KeepsTheConfiguredFilterUntilAnotherIsAskedFor) {
  LoopConfig config = TestConfig();
  config.estimator = EstimatorKind::kButterworth;
  Axis axis(config);
  axis.RenderSwinging(0.3);
  EXPECT_EQ(axis.status.filter, FilterOf(EstimatorKind::kButterworth, 10));
  EXPECT_EQ(axis.sample.filter, axis.status.filter);
  EXPECT_EQ(axis.sample.mass, 0.3);
}

TEST(FilterChangeTest, ComesAtOnceWhereNoMassIsRendered) {
  Axis axis;
  SetFilter(axis, FilterOf(EstimatorKind::kKalman, 20));
  axis.Run();
  EXPECT_EQ(axis.status.filter, axis.settings.filter);
  EXPECT_NE(axis.sample.filter, axis.settings.filter);
  axis.Run();
  EXPECT_EQ(axis.sample.filter, axis.settings.filter);
  EXPECT_EQ(axis.sample.state, State::kIdle);
}

TEST(FilterChangeTest, TakesARenderedMassToZeroFirstAndBackAfterwards) {
  Axis axis;
  axis.RenderSwinging(0.3);
  const Filter old = axis.status.filter;
  SetFilter(axis, FilterOf(EstimatorKind::kButterworth, 25));
  double mass = 0.3;
  double acceleration = axis.sample.acceleration;
  for (int k = 1; k <= 2 * kRampTicks; ++k) {
    const Sample& sample = axis.Swing();
    ASSERT_EQ(sample.filter, k <= kRampTicks ? old : axis.settings.filter) << k;
    ASSERT_NEAR(sample.mass, mass + (k <= kRampTicks ? -0.3 : 0.3) / kRampTicks, 1e-12) << k;
    ASSERT_EQ(sample.state, State::kRendering);
    // 16 m/s^2 at 2 Hz change by 0.2 a tick; a filter that began at rest would show all 16 at once.
    ASSERT_NEAR(sample.acceleration, acceleration, 0.5) << k;
    mass = sample.mass;
    acceleration = sample.acceleration;
    if (k == kRampTicks) {
      ASSERT_EQ(mass, 0);
      ASSERT_EQ(sample.force_counts, 0);
    }
  }
  EXPECT_EQ(mass, 0.3);
}

TEST(FilterChangeTest, RampsBackGentlyAlsoToAMassThatWasAskedForAtOnce) {
  Axis axis;
  axis.RenderSwinging(0.3);
  SetFilter(axis, FilterOf(EstimatorKind::kKalman, 25));
  axis.settings.mass = 0.4;
  axis.settings.ramp_s = 0;
  axis.Post();
  for (int k = 0; k < kRampTicks; ++k) {
    axis.Swing();
    ASSERT_LE(axis.sample.mass, 0.3);
  }
  ASSERT_EQ(axis.sample.mass, 0);
  axis.Swing();
  EXPECT_NEAR(axis.sample.mass, 0.4 / kRampTicks, 1e-12);
  // From then on a ramp is what it is asked to be.
  for (int k = 0; k < kRampTicks; ++k) {
    axis.Swing();
  }
  axis.settings.mass = 0.2;
  axis.Post();
  EXPECT_EQ(axis.Swing().mass, 0.2);
}

TEST(FilterChangeTest, TakenBackOnTheWayDownReturnsWithTheOldFilter) {
  Axis axis;
  axis.RenderSwinging(0.3);
  const Filter old = axis.status.filter;
  SetFilter(axis, FilterOf(EstimatorKind::kKalman, 25));
  for (int k = 0; k < kRampTicks / 2; ++k) {
    axis.Swing();
  }
  SetFilter(axis, old);
  for (int k = 0; k < kRampTicks; ++k) {
    ASSERT_EQ(axis.Swing().filter, old);
    ASSERT_GE(axis.sample.mass, 0.15 - 1e-12);
  }
  EXPECT_EQ(axis.sample.mass, 0.3);
}

TEST(FilterChangeTest, ComesAlsoWhenAStopOrAFaultHasTakenTheMassDown) {
  for (const bool stop : {true, false}) {
    Axis axis;
    axis.RenderSwinging(0.3);
    SetFilter(axis, FilterOf(EstimatorKind::kButterworth, 25));
    axis.Swing();
    if (stop) {
      axis.StopRendering();
    } else {
      axis.EmergencyStop();
    }
    for (int k = 0; k < kRampTicks + 2; ++k) {
      axis.Swing();
    }
    EXPECT_EQ(axis.status.state, stop ? State::kReady : State::kFault);
    EXPECT_EQ(axis.status.filter, axis.settings.filter);
  }
}

TEST(FilterChangeTest, ToOneThatCannotRunIsAFaultWhileRenderingAndIgnoredElsewhere) {
  for (const Filter& bad :
       {FilterOf(EstimatorKind::kKalman, 501), FilterOf(static_cast<EstimatorKind>(77), 10),
        FilterOf(EstimatorKind::kAccelerometer, 10),  // which this drive has not
        FilterOf(EstimatorKind::kButterworth, std::numeric_limits<double>::quiet_NaN())}) {
    Axis axis;
    const Filter configured = FilterOf(EstimatorKind::kFilteredDifference, 10);
    SetFilter(axis, bad);
    axis.RunTicks(3);
    EXPECT_EQ(axis.status.filter, configured);
    EXPECT_EQ(axis.status.state, State::kIdle);
    axis.settings.filter = configured;
    axis.RenderSwinging(0.3);
    SetFilter(axis, bad);
    axis.Swing();
    EXPECT_EQ(axis.status.fault.fault, Fault::kNotFinite);
    EXPECT_EQ(axis.sample.force_counts, 0);
    EXPECT_EQ(axis.status.filter, configured);
  }
}

TEST(FilterChangeTest, LeavesSamplesFromWhichEverythingFollowsBitForBit) {
  device::DriveInfo info = ScriptedDrive().info;
  info.acceleration_quantum = 0.01;
  info.accelerometer_bandwidth_hz = 120;
  Axis axis(TestConfig(), info);
  model::AccelerationEstimator estimator(axis.config.period_s, axis.config.cutoff_hz);
  Filter filter = FilterOf(EstimatorKind::kFilteredDifference, 10);
  uint64_t last_answer = 0;
  const auto follow = [&](const Sample& sample) {
    if (sample.filter != filter) {
      filter = sample.filter;
      estimator = estimator.ChangedTo(static_cast<EstimatorKind>(filter.estimator), filter.cutoff_hz);
    }
    if (!sample.position_stale) {
      estimator.Update(static_cast<double>(sample.position_counts) * axis.drive.info.position_quantum,
                       sample.tick - last_answer, sample.acceleration_counts * info.acceleration_quantum);
      last_answer = sample.tick;
    }
    ASSERT_EQ(sample.state, State::kRendering);
    ASSERT_EQ(std::bit_cast<uint64_t>(sample.acceleration), std::bit_cast<uint64_t>(estimator.acceleration()))
        << sample.tick;
  };
  axis.Start(0.3, 0.1);
  constexpr std::array kKinds{EstimatorKind::kFilteredAccelerometer, EstimatorKind::kLateFilteredDifference,
                              EstimatorKind::kAccelerometer,         EstimatorKind::kButterworth,
                              EstimatorKind::kFilteredAccelerometer, EstimatorKind::kKalman};
  for (int i = 0; i < 3000; ++i) {
    if (i % 500 == 300) {
      SetFilter(axis, FilterOf(kKinds.at(static_cast<std::size_t>(i / 500)), 10 + i / 100));
    }
    axis.drive.answers_reads = i % 50 != 7;
    follow(axis.Swing(i % 40 == 3 ? 2 : 0));
  }
  EXPECT_EQ(filter, axis.settings.filter);
}

// The intervals of a loop with each of some filters, and random masses inside.
class AdmittedMasses {
 public:
  struct Filtered {
    Filter filter;
    model::MWidth m_width;
  };

  AdmittedMasses() {
    for (const EstimatorKind kind : model::kEstimatorKinds) {
      for (const double cutoff_hz : {2.0, 10.0, 45.0}) {
        const model::LoopParameters loop{.device_mass = 0.07,
                                         .device_damping = 0.005,
                                         .hand_damping = 5,
                                         .hand_stiffness = 700,
                                         .period_s = 0.01,
                                         .cutoff_hz = cutoff_hz,
                                         .estimator = kind};
        filters_.push_back({FilterOf(kind, cutoff_hz), model::ComputeMWidth(loop)});
      }
    }
  }

  const Filtered& Any(std::mt19937_64& random) const { return filters_.at(random() % filters_.size()); }
  bool Admits(const Filter& filter, double mass) const {
    return std::find_if(filters_.begin(), filters_.end(), [&](const Filtered& filtered) {
             return filtered.filter == filter && filtered.m_width.Contains(mass);
           }) != filters_.end();
  }

 private:
  std::vector<Filtered> filters_;
};

TEST(FilterChangeTest, NeverRendersAMassOutsideOfTheIntervalOfTheRunningFilter) {
  LoopConfig config = TestConfig();
  config.period_s = 0.01;  // slow, so that ramps are 20 ticks
  config.velocity_limit = 1e6;
  const AdmittedMasses masses;
  std::mt19937_64 random(20120709);
  const auto chance = [&random](double p) {
    return std::uniform_real_distribution<double>(0, 1)(random) < p;
  };
  Axis axis(config);
  uint64_t changes = 0;
  uint64_t rendered = 0;
  Sample before;
  for (int k = 0; k < 300'000; ++k) {
    if (chance(0.05)) {
      const AdmittedMasses::Filtered& chosen = masses.Any(random);
      axis.settings.filter = chosen.filter;
      // Just inside of an edge, most often: where a wrong filter would show.
      const double share = chance(0.7) ? 0.999 : std::uniform_real_distribution<double>(0, 1)(random);
      axis.settings.mass = share * (chance(0.5) ? chosen.m_width.lower.mass : chosen.m_width.upper.mass);
      axis.settings.ramp_s = chance(0.3) ? 0 : 0.1;
      axis.Post();
    }
    if (axis.status.state != State::kRendering && chance(0.1)) {
      axis.ClearFault();
      axis.Start(axis.settings.mass, axis.settings.ramp_s);
    }
    if (chance(0.003)) {
      axis.StopRendering();
    }
    if (chance(0.001)) {
      axis.EmergencyStop();
    }
    axis.drive.answers_reads = !chance(0.01);
    const Sample& sample = axis.Swing(chance(0.02) ? random() % 4 : 0);
    ASSERT_TRUE(sample.mass == 0 || masses.Admits(sample.filter, sample.mass)) << sample.mass << " " << k;
    if (sample.filter != before.filter && k > 0) {
      ASSERT_EQ(before.mass, 0);
      ASSERT_EQ(before.force_counts, 0);
      ++changes;
    }
    rendered += sample.mass != 0 ? 1 : 0;
    before = sample;
  }
  // Nothing was proved about what never happened.
  EXPECT_GT(changes, 3000U);
  EXPECT_GT(rendered, 100'000U);
}

}  // namespace
}  // namespace mwidth::render
