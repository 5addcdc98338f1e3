#include "client/cli/timing_report.h"

#include <gtest/gtest.h>

namespace mwidth::cli {
namespace {

v1::Durations Durations(double min_s) {
  v1::Durations durations;
  durations.set_count(1000);
  durations.set_min_s(min_s);
  durations.set_p50_s(2 * min_s);
  durations.set_p99_s(10 * min_s);
  durations.set_p999_s(100 * min_s);
  durations.set_max_s(1000 * min_s);
  return durations;
}

TEST(TimingReportTest, ShowsEveryDurationInMicroseconds) {
  v1::AxisState axis;
  axis.mutable_info()->set_name("elbow");
  axis.set_missed_ticks(7);
  auto& statistics = *axis.mutable_tick_statistics();
  *statistics.mutable_wake_latency() = Durations(1.5e-6);
  *statistics.mutable_compute() = Durations(2e-6);
  *statistics.mutable_io() = Durations(1e-7);
  statistics.set_overruns(3);
  EXPECT_EQ(TimingReport(axis),
            "elbow: 1000 ticks since the start, 3 overruns, 7 ticks missed\n"
            "  microseconds               min        p50        p99      p99.9        max\n"
            "  wake-up latency            1.5          3         15        150       1500\n"
            "  computing                    2          4         20        200       2000\n"
            "  drive I/O                  0.1        0.2          1         10        100\n"
            "  loop delay            none yet\n");
}

}  // namespace
}  // namespace mwidth::cli
