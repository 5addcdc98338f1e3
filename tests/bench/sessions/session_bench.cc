// What a session costs: its file beside rows of doubles and CSV, its CPU beside appending such rows to a
// file, and an hour of it.
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <fcntl.h>
#include <unistd.h>
#include <zstd.h>
#include <CLI/CLI.hpp>

#include "server/record/export/export.h"
#include "server/record/session/session_file.h"
#include "server/record/session/session_reader.h"
#include "tests/bench/sessions/simulated_session.h"

namespace mwidth::bench {
namespace {

using exchange::Sample;
namespace fs = std::filesystem;

// As many rows as a block of a session has samples.
constexpr std::size_t kChunkRows = record::SessionFile::kBlockSamples;
constexpr int kZstdLevel = 3;  // the default of the zstd command

/// What StreamSamples sends of a sample, and its tick: as a study that keeps it in doubles would store it.
constexpr std::size_t kColumns = 14;
using Row = std::array<double, kColumns>;

Row RowOf(const Sample& sample) {
  return {static_cast<double>(sample.tick),
          static_cast<double>(sample.monotonic_ns) * 1e-9,
          sample.position,
          sample.velocity,
          sample.acceleration,
          sample.force,
          sample.mass,
          static_cast<double>(sample.state),
          sample.saturated || sample.slew_limited ? 1.0 : 0.0,
          static_cast<double>(sample.position_counts),
          static_cast<double>(sample.force_counts),
          sample.position_stale ? 1.0 : 0.0,
          static_cast<double>(sample.acceleration_counts),
          sample.force_taken ? 1.0 : 0.0};
}

struct Options {
  fs::path folder = ".";
  std::optional<fs::path> recording;
  std::size_t samples = 400'000;
  std::size_t commit_samples = 50;
  std::size_t sync_samples = 500;
  int rounds = 9;
};

std::vector<Sample> Simulate(const Options& options, Wakeups wakeups, record::SessionAxis& axis) {
  SimulatedSession simulated(wakeups, options.recording);
  axis = simulated.axis();
  std::vector<Sample> samples(options.samples);
  for (Sample& sample : samples) {
    sample = simulated.Next();
  }
  return samples;
}

record::SessionInfo InfoOf(const record::SessionAxis& axis) {
  record::SessionInfo info;
  info.labels = {
      .subject = "01", .visit = "", .task = "reach", .run = 1, .operator_name = "", .metadata = {}};
  info.axis = axis;
  return info;
}

// Calls `commit(samples, sync)` as often as a recorder would.
template <typename Commit>
void InPortions(const Options& options, const std::vector<Sample>& samples, const Commit& commit) {
  std::size_t since_sync = 0;
  for (std::size_t i = 0; i < samples.size(); i += options.commit_samples) {
    const std::span portion(samples.data() + i, std::min(options.commit_samples, samples.size() - i));
    since_sync += portion.size();
    const bool sync = since_sync >= options.sync_samples;
    since_sync = sync ? 0 : since_sync;
    commit(portion, sync);
  }
}

void WriteSession(const Options& options, const std::vector<Sample>& samples, const record::SessionAxis& axis,
                  bool syncs, const fs::path& file) {
  record::SessionFile session(file, InfoOf(axis));
  InPortions(options, samples, [&](std::span<const Sample> portion, bool sync) {
    session.Append(portion, "");
    session.Commit(sync && syncs ? record::Durability::kPower : record::Durability::kProcess);
  });
  session.End(record::SessionState::kEnded, 0);
}

void WriteRows(const Options& options, const std::vector<Sample>& samples, bool syncs, const fs::path& file) {
  const int descriptor = open(file.c_str(), O_CREAT | O_WRONLY | O_APPEND, 0600);
  std::vector<Row> rows;
  InPortions(options, samples, [&](std::span<const Sample> portion, bool sync) {
    rows.clear();
    for (const Sample& sample : portion) {
      rows.push_back(RowOf(sample));
    }
    const auto bytes = rows.size() * sizeof(Row);
    if (write(descriptor, rows.data(), bytes) != static_cast<ssize_t>(bytes)) {
      std::perror("write");
      std::exit(1);
    }
    if (sync && syncs) {
      fdatasync(descriptor);
    }
  });
  fdatasync(descriptor);
  close(descriptor);
}

void RequireSame(const std::vector<Sample>& samples, const fs::path& file) {
  record::SessionReader reader(file);
  std::vector<Sample> block;
  std::size_t at = 0;
  while (reader.Next(block)) {
    for (const Sample& sample : block) {
      if (at == samples.size() || RowOf(sample) != RowOf(samples[at])) {
        std::fprintf(stderr, "what was read is not what was written\n");
        std::exit(1);
      }
      ++at;
    }
  }
  if (at != samples.size() || !reader.Verify().empty()) {
    std::fprintf(stderr, "the session is not whole\n");
    std::exit(1);
  }
}

std::size_t ZstdBytes(const std::vector<Row>& rows, std::size_t rows_each) {
  std::vector<char> out(ZSTD_compressBound(rows_each * sizeof(Row)));
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < rows.size(); i += rows_each) {
    const std::size_t count = std::min(rows_each, rows.size() - i);
    bytes += ZSTD_compress(out.data(), out.size(), &rows[i], count * sizeof(Row), kZstdLevel);
  }
  return bytes;
}

void Sizes(const Options& options) {
  for (const Wakeups wakeups : {Wakeups::kExact, Wakeups::kLate}) {
    record::SessionAxis axis;
    const std::vector<Sample> samples = Simulate(options, wakeups, axis);
    const fs::path file = options.folder / "session.sqlite";
    fs::remove(file);
    WriteSession(options, samples, axis, false, file);
    RequireSame(samples, file);
    std::vector<Row> rows;
    for (const Sample& sample : samples) {
      rows.push_back(RowOf(sample));
    }
    const fs::path csv = options.folder / "csv";
    fs::remove_all(csv);
    record::SessionReader reader(file);
    record::ExportCsv(reader, csv, true);
    std::size_t csv_bytes = 0;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(csv)) {
      csv_bytes = std::max<std::size_t>(csv_bytes, entry.is_regular_file() ? entry.file_size() : 0);
    }
    const auto each = [&samples](std::size_t bytes) {
      return static_cast<double>(bytes) / static_cast<double>(samples.size());
    };
    const double session = each(fs::file_size(file));
    const double chunks = each(ZstdBytes(rows, kChunkRows));
    const double stream = each(ZstdBytes(rows, rows.size()));
    std::printf(
        "wake-ups %s: session %.2f bytes a sample; zstd rows %.1f (x %.1f), as one stream %.1f (x %.1f); "
        "CSV %.0f (x %.0f); rows %zu\n",
        wakeups == Wakeups::kExact ? "exact" : "late", session, chunks, chunks / session, stream,
        stream / session, each(csv_bytes), each(csv_bytes) / session, sizeof(Row));
    fs::remove(file);
    fs::remove_all(csv);
  }
}

double CpuSeconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

std::string Spread(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const auto at = [&values](double share) {
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
  };
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), "%.2f (%.2f to %.2f)", at(0.5), at(0.25), at(0.75));
  return text.data();
}

void Cpu(const Options& options) {
  record::SessionAxis axis;
  const std::vector<Sample> samples = Simulate(options, Wakeups::kLate, axis);
  const fs::path session = options.folder / "session.sqlite";
  const fs::path rows = options.folder / "rows";
  for (const bool syncs : {true, false}) {
    std::vector<double> ratios;
    std::vector<double> session_s;
    std::vector<double> rows_s;
    for (int round = 0; round < options.rounds; ++round) {
      fs::remove(session);
      fs::remove(rows);
      const double begin = CpuSeconds();
      WriteSession(options, samples, axis, syncs, session);
      const double between = CpuSeconds();
      WriteRows(options, samples, syncs, rows);
      const double end = CpuSeconds();
      const double per_million = 1e6 / static_cast<double>(samples.size());
      session_s.push_back((between - begin) * per_million);
      rows_s.push_back((end - between) * per_million);
      ratios.push_back(session_s.back() / rows_s.back());
    }
    std::printf(
        "%zu samples a commit, %s: session %s s per million samples, appended rows %s, ratio %s\n",
        options.commit_samples,
        syncs ? ("on the disk every " + std::to_string(options.sync_samples)).c_str() : "never synced",
        Spread(session_s).c_str(), Spread(rows_s).c_str(), Spread(ratios).c_str());
  }
  fs::remove(session);
  fs::remove(rows);
}

void Hour(Options options) {
  constexpr std::size_t kHourSamples = 3'600'000;
  SimulatedSession simulated(Wakeups::kLate, options.recording);
  const fs::path file = options.folder / "hour.sqlite";
  fs::remove(file);
  uintmax_t log_bytes = 0;
  {
    record::SessionFile session(file, InfoOf(simulated.axis()));
    std::vector<Sample> portion(options.commit_samples);
    for (std::size_t i = 0; i < kHourSamples; i += portion.size()) {
      std::generate(portion.begin(), portion.end(), [&simulated] { return simulated.Next(); });
      session.Append(portion, "");
      session.Commit(i % options.sync_samples == 0 ? record::Durability::kPower
                                                   : record::Durability::kProcess);
      if (i % 100'000 == 0) {
        log_bytes = std::max(log_bytes, fs::file_size(file.string() + "-wal"));
      }
    }
    session.End(record::SessionState::kEnded, 0);
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf("one hour at 1 kHz: file %.1f MB, log at most %.1f MB, peak memory of the process %.1f MB\n",
              static_cast<double>(fs::file_size(file)) / 1e6, static_cast<double>(log_bytes) / 1e6,
              static_cast<double>(usage.ru_maxrss) / 1e3);
  fs::remove(file);
}

}  // namespace
}  // namespace mwidth::bench

int main(int argc, char** argv) {
  using namespace mwidth::bench;
  Options options;
  CLI::App app("What a session costs.");
  app.require_subcommand(1);
  app.add_option("--folder", options.folder, "Where files are written: on the disk that is meant");
  app.add_option("--recording", options.recording, "A recorded hand (CSV), rather than the built-in reaches");
  app.add_option("--samples", options.samples);
  app.add_option("--commit", options.commit_samples, "Samples in a commit");
  app.add_option("--rounds", options.rounds);
  app.fallthrough();
  app.add_subcommand("sizes", "The file, beside rows of doubles and CSV")->callback([&] { Sizes(options); });
  app.add_subcommand("cpu", "CPU time, beside appending rows of doubles, by turns")->callback([&] {
    Cpu(options);
  });
  app.add_subcommand("hour", "An hour at 1 kHz")->callback([&] { Hour(options); });
  CLI11_PARSE(app, argc, argv);
  return 0;
}
