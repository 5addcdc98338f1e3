#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <system_error>

#include "client/cli/commands.h"
#include "client/cli/interrupt.h"
#include "client/cli/json.h"
#include "client/cli/sample_rows.h"
#include "client/cpp/client.h"

namespace mwidth::cli {
namespace {

// Where --samples and --seconds end the stream.
class Limit {
 public:
  explicit Limit(const CommandLine& line) : line_(line) {}

  // Whether this sample is past the end; counts it where not.
  bool Reached(int64_t monotonic_ns) {
    if (count_ == 0) {
      first_ns_ = monotonic_ns;
    }
    const double time_s = 1e-9 * static_cast<double>(monotonic_ns - first_ns_);
    if ((line_.samples && count_ >= *line_.samples) || (line_.seconds && time_s >= *line_.seconds)) {
      return true;
    }
    ++count_;
    return false;
  }
  // Whether the next sample would be past the end for its number alone.
  bool Full() const { return line_.samples && count_ >= *line_.samples; }
  uint64_t count() const { return count_; }

 private:
  const CommandLine& line_;
  uint64_t count_ = 0;
  int64_t first_ns_ = 0;
};

void ReportGap(const v1::SampleBatch& batch) {
  if (batch.missed_ticks_before() + batch.dropped_ticks_before() > 0) {
    std::cerr << "gap before tick " << batch.first_tick() << ": " << batch.missed_ticks_before()
              << " ticks missed by the loop, " << batch.dropped_ticks_before() << " not delivered\n";
  }
}

// One batch to `out`; true when the end is reached. JSON keeps batches whole.
bool WriteBatch(const v1::SampleBatch& batch, bool json, SampleRows& rows, Limit& limit, std::ostream& out) {
  bool end = false;
  for (int i = 0; i < batch.position_size() && !end; ++i) {
    end = limit.Reached(batch.monotonic_ns(i));
    if (!end && !json) {
      rows.Write(batch, i);
    }
  }
  if (json) {
    out << ToJson(batch, /*one_line=*/true);
  }
  out.flush();
  return end || limit.Full();
}

// A reader that went away, as head does, has what it wanted; a full disk is an error.
int OutputClosed() {
  if (errno == EPIPE) {
    return kDone;
  }
  throw std::system_error(errno, std::generic_category(), "cannot write the samples");
}

int Copy(client::SampleStream& stream, const CommandLine& line, SampleRows& rows, std::ostream& out) {
  Limit limit(line);
  while (const auto batch = stream.Next()) {
    ReportGap(*batch);
    errno = 0;
    const bool end = WriteBatch(*batch, line.json, rows, limit, out);
    if (!out) {
      return OutputClosed();
    }
    if (end) {
      break;
    }
  }
  std::cerr << limit.count() << " samples; " << stream.gaps().missed_ticks << " ticks missed by the loop, "
            << stream.gaps().dropped_ticks << " not delivered\n";
  return kDone;
}

}  // namespace

int RunStream(const CommandLine& line) {
  const Interrupt interrupt;
  std::ofstream file;
  if (line.csv && *line.csv != "-") {
    file.open(*line.csv);
    if (!file) {
      throw std::system_error(errno, std::generic_category(), "cannot write " + *line.csv);
    }
  }
  std::ostream& out = file.is_open() ? file : std::cout;

  const auto client = client::Client::Connect(line.server);
  const auto info = client.Axis(line.axis).info();
  const double period_s = info.loop().period_s();
  // For a terminal ten rows a second; for programs every tick.
  const double readable = std::max(1.0, std::round(0.1 / period_s));
  const auto decimation =
      line.decimation.value_or(line.csv || line.json ? 1u : static_cast<uint32_t>(readable));
  // A batch covers at most 50 ms, so that what is shown is live.
  const double batch = std::clamp(0.05 / (period_s * decimation), 1.0, 1000.0);

  const auto rows = line.csv ? CsvRows(out, UnitsOf(info.kind()), line.reduction == v1::REDUCTION_MIN_MAX)
                             : TableRows(out, UnitsOf(info.kind()));
  const uint32_t min_batch = line.min_batch.value_or(0);
  auto stream = client.Stream(line.axis, decimation, std::max(min_batch, static_cast<uint32_t>(batch)),
                              min_batch, line.reduction);
  const std::stop_callback cancel(interrupt.token(), [&stream] { stream.Cancel(); });
  return Copy(stream, line, *rows, out);
}

}  // namespace mwidth::cli
