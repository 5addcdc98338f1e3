#include "server/record/session/replay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <stdexcept>
#include <vector>

#include "device/hand_motion.h"
#include "device/simulated_drive.h"
#include "tests/server/render/random_axis.h"

namespace mwidth::record {
namespace {

using exchange::Filter;
using exchange::Sample;
using exchange::State;
using model::EstimatorKind;

SessionAxis AxisOf(const render::LoopConfig& config, const device::DriveInfo& info) {
  return {.name = "elbow",
          .rotary = true,
          .period_s = config.period_s,
          .position_quantum = info.position_quantum,
          .force_quantum = info.force_quantum,
          .acceleration_quantum = info.acceleration_quantum,
          .force_limit = config.force_limit,
          .force_slew_limit = config.force_slew_limit};
}

ReplayFigures ReplayOf(const SessionAxis& axis, const std::vector<Sample>& samples) {
  Replay replay(axis);
  for (const Sample& sample : samples) {
    replay.Add(sample);
  }
  return replay.figures();
}

// A session of ordinary work: an arm that swings under one mass after another, with a slew limit that is
// sometimes met.
struct Recording {
  SessionAxis axis;
  std::vector<Sample> samples;
};

Recording Swinging(int ticks = 3000) {
  render::LoopConfig config = render::TestConfig();
  config.force_limit = 4;
  config.force_slew_limit = 50;
  config.watch.saturation_s = config.watch.slew_s = config.watch.gap_s = 1;
  render::Axis axis(config);
  Recording recording{.axis = AxisOf(config, axis.drive.info), .samples = {}};
  axis.Start(0.3, 0.2);
  for (int i = 0; i < ticks; ++i) {
    axis.drive.takes_writes = i % 97 != 5;
    axis.drive.answers_reads = i % 89 != 7;
    recording.samples.push_back(axis.Swing(i % 101 == 50 ? 2 : 0));
  }
  return recording;
}

// What a history had in it, so that no test proves anything of what never was.
struct Seen {
  uint64_t saturated = 0;
  uint64_t slew_limited = 0;
  uint64_t stale = 0;
  uint64_t refused_writes = 0;
  uint64_t missed = 0;
  uint64_t filter_changes = 0;
  uint64_t accelerometer = 0;
  uint64_t faults = 0;
  uint64_t forces = 0;

  void Add(const Sample& sample, const Sample& before) {
    saturated += sample.saturated ? 1 : 0;
    slew_limited += sample.slew_limited ? 1 : 0;
    stale += sample.position_stale ? 1 : 0;
    refused_writes += sample.state == State::kRendering && !sample.force_taken ? 1 : 0;
    missed += sample.missed_ticks - before.missed_ticks;
    filter_changes += sample.filter != before.filter ? 1 : 0;
    accelerometer += model::IsAccelerometer(static_cast<EstimatorKind>(sample.filter.estimator)) ? 1 : 0;
    faults += sample.state == State::kFault && before.state != State::kFault ? 1 : 0;
    forces += sample.force_counts != 0 ? 1 : 0;
  }
  uint64_t Least() const {
    return std::min({saturated, slew_limited, stale, refused_writes, missed, filter_changes, accelerometer,
                     faults, forces});
  }
};

TEST(ReplayTest, GivesTheSameBitsInEveryTickOfEveryRandomHistory) {
  Seen seen;
  uint64_t compared = 0;
  constexpr uint64_t kHistories = 400;
  constexpr uint64_t kTicks = 500;
  for (uint64_t seed = 1; seed <= kHistories; ++seed) {
    render::RandomAxis random_axis(seed);
    render::Axis& axis = random_axis.axis;
    Replay replay(AxisOf(axis.config, axis.drive.info));
    Sample before;
    for (uint64_t k = 0; k < kTicks; ++k) {
      const uint64_t missed = random_axis.Disturb();
      const Sample sample = axis.Run(missed);
      axis.tick_under_test().ReportLoopDelay(random_axis.loop_delay_ns);
      if (k > 0) {
        seen.Add(sample, before);
      }
      before = sample;
      replay.Add(sample);
      ASSERT_EQ(replay.figures().different, 0) << "seed " << seed << " tick " << sample.tick << " "
                                               << Name(replay.figures().first_differences.front().column);
    }
    ASSERT_EQ(replay.figures().begun, 1);
    compared += replay.figures().compared();
  }
  EXPECT_EQ(compared, kHistories * (kTicks - 1));
  EXPECT_GT(seen.Least(), 50);
}

TEST(ReplayTest, GivesTheSameBitsWithEveryEstimatorOnASimulatedJoint) {
  constexpr std::array kKinds{EstimatorKind::kFilteredDifference,    EstimatorKind::kButterworth,
                              EstimatorKind::kAccelerometer,         EstimatorKind::kKalman,
                              EstimatorKind::kFilteredAccelerometer, EstimatorKind::kLateFilteredDifference};
  device::SimulatedDrive drive({.loop = {.device_mass = 0.2084,
                                         .device_damping = 0.1215,
                                         .hand_mass = 0.0685,
                                         .hand_damping = 1,
                                         .hand_stiffness = 25,
                                         .period_s = 1e-3,
                                         .cutoff_hz = 20,
                                         .accelerometer_bandwidth_hz = 200},
                                .position_quantum = 7.1585e-5,
                                .force_quantum = 1e-3,
                                .acceleration_quantum = 0.01},
                               std::make_unique<device::MinimumJerkReach>(device::ReachParameters{
                                   .start_position = 0, .amplitude = 0.5, .duration_s = 0.4, .hold_s = 0.1}));
  render::LoopConfig config = render::TestConfig();
  config.watch.acceleration_limit = 1e6;
  auto crossing = std::make_unique<exchange::Crossing>();
  render::Tick tick(config, drive, *crossing);
  Replay replay(AxisOf(config, drive.Info()));
  exchange::Settings settings{
      .sequence = 1, .rendering = true, .render_epoch = 1, .lease_deadline_ns = INT64_MAX};
  uint64_t number = 0;
  std::array<uint64_t, kKinds.size()> forces{};
  for (std::size_t phase = 0; phase < 2 * kKinds.size(); ++phase) {
    const EstimatorKind kind = kKinds[phase % kKinds.size()];
    settings.filter = {.estimator = static_cast<uint8_t>(kind),
                       .cutoff_hz = 15.0 + static_cast<double>(phase)};
    settings.mass = phase % 2 == 0 ? 0.15 : -0.05;
    ++settings.sequence;
    crossing->settings.Post(settings);
    for (int i = 0; i < 2000; ++i) {
      const uint64_t missed = i % 331 == 7 ? 3 : 0;
      number += 1 + missed;
      tick.Run(number, static_cast<int64_t>(number) * 1'000'000, missed);
      Sample sample;
      ASSERT_TRUE(crossing->samples.Pop(sample));
      replay.Add(sample);
      ASSERT_EQ(sample.state, State::kRendering) << model::Name(kind) << " " << i;
      forces[phase % kKinds.size()] += sample.filter == settings.filter && sample.force_counts != 0 ? 1 : 0;
    }
    ASSERT_EQ(replay.figures().different, 0) << model::Name(kind);
  }
  EXPECT_EQ(replay.figures().compared(), 2 * kKinds.size() * 2000 - 1);
  EXPECT_GT(*std::min_element(forces.begin(), forces.end()), 1000);
}

TEST(ReplayTest, BeginsAnewAfterLostSamplesAndSaysSo) {
  const Recording whole = Swinging();
  ASSERT_TRUE(ReplayOf(whole.axis, whole.samples).proves());
  std::vector<Sample> torn;
  for (std::size_t k = 0; k < whole.samples.size(); ++k) {
    if (k < 500 || (k >= 600 && k < 1000) || k >= 1001) {
      torn.push_back(whole.samples[k]);
    }
  }
  const ReplayFigures figures = ReplayOf(whole.axis, torn);
  EXPECT_EQ(figures.losses, 2);
  EXPECT_EQ(figures.begun, 3);
  EXPECT_EQ(figures.different, 0);
  EXPECT_EQ(figures.force_unknown, 0);
  EXPECT_EQ(figures.compared(), torn.size() - 3);
}

TEST(ReplayTest, DoesNotJudgeAForceWhoseStepStartsFromALostOne) {
  const Recording whole = Swinging();
  std::vector<Sample> torn(whole.samples.begin(), whole.samples.begin() + 500);
  std::size_t k = 600;
  while (whole.samples[k].force_taken) {
    ++k;
  }
  torn.insert(torn.end(), whole.samples.begin() + static_cast<std::ptrdiff_t>(k), whole.samples.end());
  const ReplayFigures figures = ReplayOf(whole.axis, torn);
  EXPECT_EQ(figures.force_unknown, 1);  // The next one is taken.
  EXPECT_EQ(figures.different, 0);
  EXPECT_EQ(figures.compared(), torn.size() - 3);
  // Where the step is not limited, that force has no say.
  SessionAxis unlimited = whole.axis;
  unlimited.force_slew_limit = std::numeric_limits<double>::infinity();
  EXPECT_EQ(ReplayOf(unlimited, torn).force_unknown, 0);
}

TEST(ReplayTest, TakesMissedTicksForNoLoss) {
  const Recording whole = Swinging();
  ASSERT_GT(whole.samples.back().missed_ticks, 20);
  EXPECT_EQ(ReplayOf(whole.axis, whole.samples).losses, 0);
}

double WithBit(double value, int bit) {
  return std::bit_cast<double>(std::bit_cast<uint64_t>(value) ^ (uint64_t{1} << bit));
}

// A tick in the midst of things: a force that no limit clamps.
std::size_t OrdinaryTick(const Recording& recording) {
  std::size_t k = 1500;
  while (recording.samples[k].saturated || recording.samples[k].slew_limited ||
         recording.samples[k].position_stale || std::abs(recording.samples[k].force_counts) < 500) {
    ++k;
  }
  return k;
}

TEST(ReplayTest, NamesTheTickAndTheColumnOfOneAlteredBit) {
  const Recording whole = Swinging();
  const std::size_t k = OrdinaryTick(whole);
  const auto first_difference = [&](const auto& alter) {
    Recording altered = whole;
    alter(altered.samples[k]);
    const ReplayFigures figures = ReplayOf(altered.axis, altered.samples);
    EXPECT_FALSE(figures.proves());
    EXPECT_EQ(figures.first_differences.at(0).tick, whole.samples[k].tick);
    return figures.first_differences.at(0);
  };
  for (int bit = 0; bit < 64; ++bit) {
    const auto flip = [bit](double& value) { value = WithBit(value, bit); };
    EXPECT_EQ(first_difference([&](Sample& s) { flip(s.position); }).column, ReplayedColumn::kPosition);
    EXPECT_EQ(first_difference([&](Sample& s) { flip(s.velocity); }).column, ReplayedColumn::kVelocity);
    EXPECT_EQ(first_difference([&](Sample& s) { flip(s.acceleration); }).column,
              ReplayedColumn::kAcceleration);
    EXPECT_EQ(first_difference([&](Sample& s) { flip(s.force); }).column, ReplayedColumn::kForce);
  }
  for (int bit = 0; bit < 31; ++bit) {
    const auto alter = [bit](Sample& s) { s.force_counts ^= 1 << bit; };
    EXPECT_EQ(first_difference(alter).column, ReplayedColumn::kForceCounts) << bit;
  }
  for (int bit = 0; bit < 40; ++bit) {
    const auto alter = [bit](Sample& s) { s.position_counts ^= int64_t{1} << bit; };
    EXPECT_EQ(first_difference(alter).column, ReplayedColumn::kPosition) << bit;
  }
  EXPECT_EQ(first_difference([](Sample& s) { s.saturated = true; }).column, ReplayedColumn::kSaturated);
  EXPECT_EQ(first_difference([](Sample& s) { s.slew_limited = true; }).column, ReplayedColumn::kSlewLimited);
}

TEST(ReplayTest, FindsAnAlteredCountAndPositionTogetherByTheMotionThatFollows) {
  Recording altered = Swinging();
  const std::size_t k = OrdinaryTick(altered);
  Sample& sample = altered.samples[k];
  sample.position_counts += 1;
  sample.position = static_cast<double>(sample.position_counts) * altered.axis.position_quantum;
  const ReplayFigures figures = ReplayOf(altered.axis, altered.samples);
  ASSERT_FALSE(figures.proves());
  EXPECT_EQ(figures.first_differences[0].tick, sample.tick);
  EXPECT_EQ(figures.first_differences[0].column, ReplayedColumn::kVelocity);
  EXPECT_EQ(figures.first_differences[0].recorded, sample.velocity);
  EXPECT_EQ(figures.first_differences.size(), Replay::kMaxDifferences);
}

TEST(ReplayTest, FindsAnAlteredMassWhereAForceDependsOnIt) {
  const Recording whole = Swinging();
  const std::size_t k = OrdinaryTick(whole);
  // One count of at least 500 is 1/500 at most: bit 44 of the mantissa is 1/256 or more.
  for (int bit = 44; bit < 63; ++bit) {
    Recording altered = whole;
    altered.samples[k].mass = WithBit(altered.samples[k].mass, bit);
    const ReplayFigures figures = ReplayOf(altered.axis, altered.samples);
    ASSERT_FALSE(figures.proves()) << bit;
    EXPECT_EQ(figures.different, 1);
    EXPECT_EQ(figures.first_differences[0].tick, whole.samples[k].tick);
    EXPECT_EQ(figures.first_differences[0].column, ReplayedColumn::kForceCounts);
  }
}

TEST(ReplayTest, FindsForceOfAnotherDriveSettingOrFilter) {
  const Recording whole = Swinging();
  Recording other = whole;
  other.axis.force_limit = 3;
  EXPECT_FALSE(ReplayOf(other.axis, other.samples).proves());
  other = whole;
  other.axis.force_slew_limit = 51;
  EXPECT_FALSE(ReplayOf(other.axis, other.samples).proves());
  other = whole;
  for (Sample& sample : other.samples) {
    sample.filter.cutoff_hz = std::nextafter(sample.filter.cutoff_hz, 0);
  }
  EXPECT_FALSE(ReplayOf(other.axis, other.samples).proves());
}

TEST(ReplayTest, ProvesNothingOfFiltersThatDoNotExistNorOfNothing) {
  Recording recording = Swinging(100);
  EXPECT_FALSE(ReplayOf(recording.axis, {}).proves());
  for (Sample& sample : recording.samples) {
    sample.filter.cutoff_hz = std::numeric_limits<double>::quiet_NaN();
  }
  const ReplayFigures figures = ReplayOf(recording.axis, recording.samples);
  EXPECT_EQ(figures.filter_unknown, 100);
  EXPECT_FALSE(figures.proves());
}

TEST(ReplayTest, RefusesAnAxisThatNoLoopHas) {
  for (const double wrong :
       {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    SessionAxis axis = Swinging(1).axis;
    axis.force_quantum = wrong;
    EXPECT_THROW(Replay{axis}, std::invalid_argument);
  }
}

}  // namespace
}  // namespace mwidth::record
