#include "server/record/reduction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

#include "tests/server/record/samples.h"

namespace mwidth::record {
namespace {

using exchange::Sample;

/// Response of the whole, symmetric filter to a sinusoid of so many cycles a tick.
double Response(const std::vector<double>& taps, double frequency) {
  double sum = taps[0];
  for (std::size_t i = 1; i < taps.size(); ++i) {
    sum += 2 * taps[i] * std::cos(2 * std::numbers::pi * frequency * static_cast<double>(i));
  }
  return sum;
}

TEST(ReductionTest, TheLowPassIsFlatInItsBandAndDarkBeyondTheNewNyquistFrequency) {
  for (const uint32_t decimation : {2u, 3u, 4u, 5u, 7u, 10u, 33u, 100u, 1000u}) {
    const std::vector<double> taps = LowPassTaps(decimation);
    const double nyquist = 0.5 / decimation;
    EXPECT_NEAR(Response(taps, 0), 1, 1e-12);
    for (int i = 0; i <= 400; ++i) {
      const double passed = Response(taps, 0.8 * nyquist * i / 400);
      ASSERT_NEAR(20 * std::log10(passed), 0, 0.001) << decimation << " " << i;
      // Where the side lobes are highest, and over the whole band.
      for (const double frequency : {nyquist * (1 + i / 200.0), nyquist + (0.5 - nyquist) * i / 400}) {
        ASSERT_LT(std::abs(Response(taps, frequency)), 1e-4) << decimation << " " << frequency / nyquist;
      }
    }
  }
}

TEST(ReductionTest, TheLowPassOfOneTickIsThatTick) {
  Reducer reducer(Reduction::kLowPass, 1);
  Sample sample = SampleAt(5);
  sample.position = 0.3;
  const auto reduced = reducer.Push(sample);
  ASSERT_TRUE(reduced);
  EXPECT_EQ(reduced->sample.tick, 5);
  EXPECT_EQ(reduced->sample.position, 0.3);
}

/// Samples of a sinusoid in every filtered column, each at its own amplitude.
Sample Sinusoid(uint64_t tick, double frequency) {
  Sample sample = SampleAt(tick);
  const double value = std::sin(2 * std::numbers::pi * frequency * static_cast<double>(tick) + 0.3);
  sample.position = value;
  sample.velocity = 2 * value;
  sample.acceleration = 3 * value;
  sample.force = 4 * value;
  sample.mass = 5 * value;
  sample.position_counts = static_cast<int64_t>(tick);
  return sample;
}

TEST(ReductionTest, ASlowMotionLeavesTheLowPassInPlaceAndAFastOneDoesNotLeaveIt) {
  constexpr uint32_t kDecimation = 10;
  for (const double of_nyquist : {0.1, 0.79, 1.0, 1.5, 3.7}) {
    DecimatingFilter filter(kDecimation);
    const double frequency = of_nyquist * 0.5 / kDecimation;
    int left = 0;
    for (uint64_t tick = 1; tick < 3000; ++tick) {
      const std::optional<Sample> out = filter.Push(Sinusoid(tick, frequency));
      if (!out) {
        continue;
      }
      ++left;
      const Sample in = Sinusoid(out->tick, frequency);
      const double gain = of_nyquist < 0.8 ? 1 : 0;
      ASSERT_EQ(out->tick % kDecimation, 0);
      ASSERT_EQ(out->position_counts, in.position_counts) << "picked, not filtered";
      ASSERT_NEAR(out->position, gain * in.position, 1.2e-4);
      ASSERT_NEAR(out->velocity, gain * in.velocity, 2.4e-4);
      ASSERT_NEAR(out->acceleration, gain * in.acceleration, 3.6e-4);
      ASSERT_NEAR(out->force, gain * in.force, 4.8e-4);
      ASSERT_NEAR(out->mass, gain * in.mass, 6e-4);
    }
    EXPECT_GT(left, 240);
  }
}

TEST(ReductionTest, TheLowPassIsTheSumOfItsDefinition) {
  constexpr uint32_t kDecimation = 3;
  const std::vector<double> taps = LowPassTaps(kDecimation);
  const auto reach = static_cast<int64_t>(taps.size()) - 1;
  DecimatingFilter filter(kDecimation);
  for (uint64_t tick = 1; tick < 1000; ++tick) {
    const std::optional<Sample> out = filter.Push(Sinusoid(tick, 0.02));
    if (out) {
      double sum = 0;
      for (int64_t i = -reach; i <= reach; ++i) {
        sum += taps[static_cast<std::size_t>(std::abs(i))] *
               Sinusoid(out->tick + static_cast<uint64_t>(i), 0.02).position;
      }
      ASSERT_NEAR(out->position, sum, 1e-14);
    }
  }
}

TEST(ReductionTest, TheLowPassSendsNoSampleThatAGapTouches) {
  constexpr uint32_t kDecimation = 4;
  Reducer reducer(Reduction::kLowPass, kDecimation);
  const uint64_t reach = LowPassTaps(kDecimation).size() - 1;
  std::vector<uint64_t> ticks;
  const auto push = [&](uint64_t from, uint64_t to) {
    for (uint64_t tick = from; tick < to; ++tick) {
      if (const auto reduced = reducer.Push(SampleAt(tick))) {
        ticks.push_back(reduced->sample.tick);
      }
    }
  };
  push(10, 1000);
  reducer.Reset();
  push(1003, 2000);
  for (const uint64_t tick : ticks) {
    EXPECT_TRUE((tick >= 10 + reach && tick + reach < 1000) || (tick >= 1003 + reach && tick + reach < 2000))
        << tick;
  }
  // Every other multiple is there.
  uint64_t expected = 0;
  for (uint64_t tick = 0; tick < 2000; tick += kDecimation) {
    expected +=
        (tick >= 10 + reach && tick + reach < 1000) || (tick >= 1003 + reach && tick + reach < 2000) ? 1 : 0;
  }
  EXPECT_EQ(ticks.size(), expected);
}

TEST(ReductionTest, ExtremesCoverEveryTickOnce) {
  constexpr uint32_t kDecimation = 5;
  Reducer reducer(Reduction::kMinMax, kDecimation);
  std::vector<double> seen;
  for (uint64_t tick = 0; tick <= 100; ++tick) {
    const Sample sample = Sinusoid(tick, 0.07);
    seen.push_back(sample.position);
    const auto reduced = reducer.Push(sample);
    ASSERT_EQ(reduced.has_value(), tick % kDecimation == 0);
    if (reduced) {
      const auto [min, max] = std::minmax_element(seen.begin(), seen.end());
      EXPECT_EQ(reduced->extremes.position_min, *min);
      EXPECT_EQ(reduced->extremes.position_max, *max);
      EXPECT_EQ(reduced->extremes.velocity_max, 2 * *max);
      EXPECT_EQ(reduced->extremes.acceleration_min, 3 * *min);
      EXPECT_EQ(reduced->extremes.force_max, 4 * *max);
      EXPECT_EQ(reduced->sample.position, sample.position);
      seen.clear();
    }
  }
}

}  // namespace
}  // namespace mwidth::record
