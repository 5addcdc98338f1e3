#include "server/exchange/clock.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <ctime>
#include <thread>

namespace mwidth::exchange {
namespace {

// Fast enough that no test waits for it.
constexpr double kSpeed = 1e6;

TEST(MonotonicClockTest, NeverGoesBackAndSleepsUntilTheDeadlineOrLonger) {
  MonotonicClock clock;
  const int64_t start = clock.NowNs();
  const int64_t deadline = start + 1'000'000;
  clock.SleepUntilNs(deadline);
  EXPECT_GE(clock.NowNs(), deadline);
  clock.SleepUntilNs(start);  // Past: returns at once.
  EXPECT_GE(clock.NowNs(), deadline);
}

// CPU time that the thread spends on waiting for some deadlines.
int64_t CpuTimeOfWaits(MonotonicClock& clock) {
  timespec before{};
  timespec after{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &before);
  for (int i = 0; i < 10; ++i) {
    const int64_t deadline = clock.NowNs() + 5'000'000;
    clock.SleepUntilNs(deadline);
    EXPECT_GE(clock.NowNs(), deadline);
  }
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &after);
  return (after.tv_sec - before.tv_sec) * 1'000'000'000 + after.tv_nsec - before.tv_nsec;
}

TEST(MonotonicClockTest, PollsTheLastStretchBeforeADeadlineWhereItIsAskedTo) {
  MonotonicClock sleeping;
  MonotonicClock spinning(4'000'000);
  EXPECT_GT(CpuTimeOfWaits(spinning), 3 * CpuTimeOfWaits(sleeping));
  const int64_t start = spinning.NowNs();
  spinning.SleepUntilNs(start - 1);  // Past: returns at once.
  EXPECT_GE(spinning.NowNs(), start);
}

TEST(SimulatedClockTest, StandsStillUnlessTheLoopSleeps) {
  SimulatedClock clock(kSpeed);
  const int64_t start = clock.NowNs();
  MonotonicClock real;
  real.SleepUntilNs(real.NowNs() + 1'000'000);
  EXPECT_EQ(clock.NowNs(), start);
}

TEST(SimulatedClockTest, WakesExactlyAtEveryDeadlineHoweverLongTheLoopStalls) {
  SimulatedClock clock(kSpeed);
  MonotonicClock real;
  int64_t deadline = clock.NowNs();
  for (int i = 0; i < 2000; ++i) {
    deadline += 1'000'000;
    clock.SleepUntilNs(deadline);
    ASSERT_EQ(clock.NowNs(), deadline);
    if (i == 1000) {
      real.SleepUntilNs(real.NowNs() + 5'000'000);
    }
  }
}

TEST(SimulatedClockTest, ShowsOtherThreadsATimeThatNeverGoesBack) {
  SimulatedClock clock(kSpeed);
  const int64_t start = clock.NowNs();
  constexpr int64_t kSteps = 100'000;
  std::atomic<bool> done{false};
  std::thread loop([&] {
    for (int64_t i = 1; i <= kSteps; ++i) {
      clock.SleepUntilNs(start + i * 1000);
    }
    done.store(true);
  });
  int64_t last = start;
  int64_t backwards = 0;
  while (!done.load()) {
    const int64_t now = clock.NowNs();
    backwards += now < last ? 1 : 0;
    last = now;
  }
  loop.join();
  EXPECT_EQ(backwards, 0);
  EXPECT_EQ(clock.NowNs(), start + kSteps * 1000);
}

}  // namespace
}  // namespace mwidth::exchange
