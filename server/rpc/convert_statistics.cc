#include "server/rpc/convert_statistics.h"

namespace mwidth::rpc {
namespace {

double Seconds(int64_t ns) { return 1e-9 * static_cast<double>(ns); }

void Convert(const exchange::DurationHistogram& histogram, v1::Durations& message) {
  const exchange::DurationFigures figures = histogram.Figures();
  message.set_count(figures.count);
  message.set_min_s(Seconds(figures.min_ns));
  message.set_p50_s(Seconds(figures.p50_ns));
  message.set_p99_s(Seconds(figures.p99_ns));
  message.set_p999_s(Seconds(figures.p999_ns));
  message.set_max_s(Seconds(figures.max_ns));
}

}  // namespace

void Convert(const exchange::TickStatistics& statistics, v1::TickStatistics& message) {
  Convert(statistics.wake_latency(), *message.mutable_wake_latency());
  Convert(statistics.compute(), *message.mutable_compute());
  Convert(statistics.io(), *message.mutable_io());
  Convert(statistics.loop_delay(), *message.mutable_loop_delay());
  message.set_overruns(statistics.overruns());
}

}  // namespace mwidth::rpc
