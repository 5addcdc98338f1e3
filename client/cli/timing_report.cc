#include "client/cli/timing_report.h"

#include <iomanip>
#include <sstream>

#include "client/cli/numbers.h"

namespace mwidth::cli {
namespace {

constexpr int kNameWidth = 19;
constexpr int kWidth = 11;
constexpr int kDigits = 4;

void AppendRow(const std::string& name, const v1::Durations& durations, std::ostringstream& out) {
  out << "  " << std::left << std::setw(kNameWidth) << name << std::right;
  if (durations.count() == 0) {
    out << std::setw(kWidth) << "none yet"
        << "\n";
    return;
  }
  for (const double seconds :
       {durations.min_s(), durations.p50_s(), durations.p99_s(), durations.p999_s(), durations.max_s()}) {
    out << std::setw(kWidth) << Rounded(1e6 * seconds, kDigits);
  }
  out << "\n";
}

}  // namespace

std::string TimingReport(const v1::AxisState& axis) {
  const v1::TickStatistics& statistics = axis.tick_statistics();
  std::ostringstream out;
  out << axis.info().name() << ": " << statistics.wake_latency().count() << " ticks since the start, "
      << statistics.overruns() << " overruns, " << axis.missed_ticks() << " ticks missed\n";
  out << "  " << std::left << std::setw(kNameWidth) << "microseconds" << std::right;
  for (const char* column : {"min", "p50", "p99", "p99.9", "max"}) {
    out << std::setw(kWidth) << column;
  }
  out << "\n";
  AppendRow("wake-up latency", statistics.wake_latency(), out);
  AppendRow("computing", statistics.compute(), out);
  AppendRow("drive I/O", statistics.io(), out);
  AppendRow("loop delay", statistics.loop_delay(), out);
  return out.str();
}

}  // namespace mwidth::cli
