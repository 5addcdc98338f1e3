#include "client/cli/session/trial.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace mwidth::cli::session {
namespace {

using exchange::Sample;
using exchange::State;
using testing::ElementsAre;
using testing::Pair;

constexpr double kPeriodS = 1e-3;

Sample At(uint64_t tick, double mass = 0.1, State state = State::kRendering) {
  Sample sample;
  sample.tick = tick;
  sample.monotonic_ns = static_cast<int64_t>(tick) * 1'000'000;
  sample.state = state;
  sample.mass = mass;
  sample.position = static_cast<double>(tick);
  return sample;
}

record::Marker MarkerAt(double second, const std::string& kind, const std::string& label = "") {
  return {
      .label = label, .kind = kind, .metadata = {{kind, label}}, .monotonic_ns = std::llround(second * 1e9)};
}

std::vector<Trial> Split(const std::vector<record::Marker>& markers, const std::vector<Sample>& samples) {
  std::vector<Trial> trials;
  TrialSplitter splitter(markers, kPeriodS, [&trials](Trial&& trial) { trials.push_back(std::move(trial)); });
  for (const Sample& sample : samples) {
    splitter.Add(sample);
  }
  splitter.End();
  return trials;
}

std::vector<Sample> Rendering(uint64_t from, uint64_t to, double mass = 0.1) {
  std::vector<Sample> samples;
  for (uint64_t tick = from; tick < to; ++tick) {
    samples.push_back(At(tick, mass));
  }
  return samples;
}

TEST(TrialSplitterTest, CutsAtMarkersWhateverIsRendered) {
  auto samples = Rendering(0, 10'000);
  for (Sample& sample : samples) {
    sample.mass = sample.tick < 2500 ? 0.1 : 0.2;
    sample.state = sample.tick % 2 == 0 ? State::kRendering : State::kReady;
  }
  // Not in the order of time, as markers may come.
  const auto trials = Split({MarkerAt(5, "trial_start", "b"), MarkerAt(2, "trial_start", "a"),
                             MarkerAt(3, "trial_end", "good"), MarkerAt(4, "note", "coffee")},
                            samples);
  ASSERT_EQ(trials.size(), 2);
  EXPECT_EQ(trials[0].label, "a");
  EXPECT_EQ(trials[0].tick.front(), 2000);
  EXPECT_EQ(trials[0].tick.back(), 2999);
  EXPECT_EQ(trials[0].not_rendering_ticks, 500);
  EXPECT_THAT(trials[0].metadata, ElementsAre(Pair("trial_end", "good"), Pair("trial_start", "a")));
  EXPECT_EQ(trials[1].tick.front(), 5000);  // Never ended: until the session ends.
  EXPECT_EQ(trials[1].tick.back(), 9999);
}

TEST(TrialSplitterTest, EndsATrialWhereTheNextOneStarts) {
  const auto trials =
      Split({MarkerAt(1, "trial_start", "a"), MarkerAt(2, "trial_start", "b"), MarkerAt(3, "trial_end")},
            Rendering(0, 5000));
  ASSERT_EQ(trials.size(), 2);
  EXPECT_EQ(trials[0].tick.back(), 1999);
  EXPECT_EQ(trials[1].tick.front(), 2000);
  EXPECT_EQ(trials[1].tick.back(), 2999);
}

TEST(TrialSplitterTest, TellsTrialsWithoutASample) {
  const auto trials = Split({MarkerAt(0.1, "trial_start", "before"), MarkerAt(0.2, "trial_end"),
                             MarkerAt(9, "trial_start", "after")},
                            Rendering(1000, 2000));
  ASSERT_EQ(trials.size(), 2);
  EXPECT_TRUE(trials[0].tick.empty());
  EXPECT_EQ(trials[1].label, "after");
  EXPECT_TRUE(trials[1].tick.empty());
}

TEST(TrialSplitterTest, WithoutMarkersTakesTimesOfRenderingUnderOneMass) {
  auto samples = Rendering(1000, 2000, 0.1);
  for (uint64_t tick = 2000; tick < 2200; ++tick) {  // A ramp.
    samples.push_back(At(tick, 0.1 + static_cast<double>(tick - 1999) * 1e-3));
  }
  const auto held = Rendering(2200, 3000, 0.3);
  samples.insert(samples.end(), held.begin(), held.end());
  samples.push_back(At(3000, 0, State::kReady));
  const auto brief = Rendering(3001, 3400, 0.3);  // Shorter than half a second.
  samples.insert(samples.end(), brief.begin(), brief.end());
  const auto trials = Split({MarkerAt(1.5, "note", "no trial")}, samples);
  ASSERT_EQ(trials.size(), 2);
  EXPECT_EQ(trials[0].tick.front(), 1000);
  EXPECT_EQ(trials[0].tick.back(), 1999);
  EXPECT_FALSE(trials[0].marked);
  EXPECT_EQ(trials[1].tick.front(), 2200);
  EXPECT_EQ(trials[1].mass.front(), 0.3);
}

TEST(TrialSplitterTest, CutsWhatIsTooLongSoThatMemoryStaysBounded) {
  const uint64_t longest = 120'000;
  const auto rendered = Split({}, Rendering(0, 2 * longest + 1000));
  ASSERT_EQ(rendered.size(), 3);
  EXPECT_TRUE(rendered[0].cut);
  EXPECT_EQ(rendered[1].tick.front(), longest + 1);
  EXPECT_FALSE(rendered[2].cut);
  const auto marked = Split({MarkerAt(0, "trial_start")}, Rendering(0, 2 * longest));
  ASSERT_EQ(marked.size(), 1);
  EXPECT_TRUE(marked[0].cut);
  EXPECT_EQ(marked[0].tick.size(), longest + 1);
}

TEST(TrialSplitterTest, LeavesStalePositionsOutAndCountsWhatClampedTheForce) {
  auto samples = Rendering(0, 1000);
  for (Sample& sample : samples) {
    sample.position_stale = sample.tick % 10 == 0;
    sample.saturated = sample.tick % 4 == 1;
    sample.slew_limited = sample.tick % 5 == 2;
    sample.filter = {.estimator = 0, .cutoff_hz = sample.tick < 500 ? 10.0 : 20.0};
  }
  const auto trials = Split({MarkerAt(0, "trial_start")}, samples);
  ASSERT_EQ(trials.size(), 1);
  EXPECT_EQ(trials[0].tick.size(), 900);
  EXPECT_EQ(trials[0].stale_ticks, 100);
  EXPECT_EQ(trials[0].saturated_ticks, 250);
  EXPECT_EQ(trials[0].slew_limited_ticks, 200);
  ASSERT_EQ(trials[0].filters.size(), 2);
  EXPECT_EQ(trials[0].tick[trials[0].filters[1].first], 501);  // The first with a position.
}

}  // namespace
}  // namespace mwidth::cli::session
