#include "server/exchange/histogram.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <thread>
#include <vector>

namespace mwidth::exchange {
namespace {

DurationFigures FiguresOf(const std::vector<int64_t>& durations_ns) {
  const auto histogram = std::make_unique<DurationHistogram>();
  for (const int64_t duration : durations_ns) {
    histogram->Record(duration);
  }
  return histogram->Figures();
}

// The smallest recorded duration that at least `share` of them do not exceed.
int64_t Exact(std::vector<int64_t> durations_ns, double share) {
  std::sort(durations_ns.begin(), durations_ns.end());
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(durations_ns.size())));
  return durations_ns[std::max<std::size_t>(rank, 1) - 1];
}

TEST(DurationHistogramTest, SaysNothingOfNothing) {
  const DurationFigures figures = FiguresOf({});
  EXPECT_EQ(figures.count, 0);
  EXPECT_EQ(figures.min_ns, 0);
  EXPECT_EQ(figures.p50_ns, 0);
  EXPECT_EQ(figures.max_ns, 0);
}

TEST(DurationHistogramTest, IsExactForASingleDuration) {
  for (const int64_t duration : {int64_t{0}, int64_t{1}, int64_t{127}, int64_t{128}, int64_t{1'000'003}}) {
    const DurationFigures figures = FiguresOf({duration});
    EXPECT_EQ(figures.count, 1);
    EXPECT_EQ(figures.min_ns, duration);
    EXPECT_EQ(figures.p50_ns, duration);
    EXPECT_EQ(figures.p999_ns, duration);
    EXPECT_EQ(figures.max_ns, duration);
  }
}

TEST(DurationHistogramTest, PutsEveryPercentileAtMostOneInSixtyFourTooHigh) {
  std::mt19937_64 random(20120701);  // NOLINT(cert-msc51-cpp): a fixed seed, so that a failure comes again
  for (int round = 0; round < 200; ++round) {
    std::vector<int64_t> durations(1 + random() % 3000);
    std::lognormal_distribution<double> spread(std::uniform_real_distribution<double>(0, 20)(random), 1.5);
    for (int64_t& duration : durations) {
      duration = static_cast<int64_t>(std::min(spread(random), 6e10));
    }
    const DurationFigures figures = FiguresOf(durations);
    EXPECT_EQ(figures.count, durations.size());
    EXPECT_EQ(figures.min_ns, *std::min_element(durations.begin(), durations.end()));
    EXPECT_EQ(figures.max_ns, *std::max_element(durations.begin(), durations.end()));
    for (const auto& [share, told] : {std::pair{0.5, figures.p50_ns}, std::pair{0.99, figures.p99_ns},
                                      std::pair{0.999, figures.p999_ns}}) {
      const int64_t exact = Exact(durations, share);
      EXPECT_GE(told, exact) << share;
      EXPECT_LE(told, exact + exact / 64) << share;
    }
  }
}

TEST(DurationHistogramTest, SeparatesNeighboursAtEveryEndOfABucket) {
  // With both once, the median is the lower one to within its bucket: it must not reach the upper one where
  // that begins a new bucket.
  for (int bits = 7; bits < 36; ++bits) {
    const int64_t power = int64_t{1} << bits;
    EXPECT_EQ(FiguresOf({power - 1, power}).p50_ns, power - 1) << bits;
    EXPECT_EQ(FiguresOf({power, power + power / 64}).p50_ns, power + power / 64 - 1) << bits;
  }
}

TEST(DurationHistogramTest, KeepsWhatIsNegativeOrBeyondItsRange) {
  const int64_t hour = 3'600'000'000'000;
  const DurationFigures figures = FiguresOf({-5, hour, hour});
  EXPECT_EQ(figures.count, 3);
  EXPECT_EQ(figures.p50_ns, hour);
  EXPECT_EQ(figures.min_ns, 0);
  EXPECT_EQ(figures.max_ns, hour);
  EXPECT_EQ(figures.p99_ns, hour);
}

TEST(DurationHistogramTest, IsReadWhileItIsFilledAndLosesNothing) {
  constexpr int kRecords = 200'000;
  const auto histogram = std::make_unique<DurationHistogram>();
  std::atomic<int> recorded{0};
  std::thread writer([&] {
    for (int i = 1; i <= kRecords; ++i) {
      histogram->Record(i);
      recorded.store(i, std::memory_order_release);
    }
  });
  uint64_t last = 0;
  while (last < kRecords) {
    const auto at_least = static_cast<uint64_t>(recorded.load(std::memory_order_acquire));
    const DurationFigures figures = histogram->Figures();
    ASSERT_GE(figures.count, at_least);
    ASSERT_GE(figures.count, last);
    ASSERT_LE(figures.count, kRecords);
    ASSERT_LE(figures.p50_ns, figures.p99_ns);
    ASSERT_LE(figures.p99_ns, figures.p999_ns);
    ASSERT_LE(figures.p999_ns, figures.max_ns);
    last = figures.count;
  }
  writer.join();
  EXPECT_EQ(histogram->Figures().count, kRecords);
}

}  // namespace
}  // namespace mwidth::exchange
