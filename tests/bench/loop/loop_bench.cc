// How punctual the rendering loop is beside a loop that does nothing, while the server is as busy as it can
// be.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <future>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "server/render/wakeful_cpus.h"
#include "tests/bench/loop/bare_loop.h"
#include "tests/bench/loop/overload.h"
#include "tests/bench/loop/server_rig.h"
#include "tests/bench/loop/watched_clock.h"

namespace mwidth::bench {
namespace {

struct Options {
  int rounds = 5;
  double seconds = 6;
  double warm_up_s = 2;
  int cpu = 0;
  std::string overload;
};

/// How one pair of loops is run.
struct Setting {
  double period_s = 1e-3;
  int64_t spin_ns = 0;
  bool overload = false;
  bool cyclictest = false;
};

/// The same seconds of both loops.
struct Pair {
  Watched bare;
  Watched whole;
  OverloadReport overload;
  uint64_t samples_dropped_by_the_loop = 0;
  bool rendering = false;
  std::string cyclictest;
};

std::string Shell(const std::string& command) {
  std::string answer;
  if (FILE* pipe = popen(command.c_str(), "r")) {
    std::array<char, 256> part{};
    while (std::fgets(part.data(), part.size(), pipe) != nullptr) {
      answer += part.data();
    }
    pclose(pipe);
  }
  return answer;
}

// The newest line of its figures, in microseconds.
std::string Cyclictest(const Options& options, double period_s) {
  const std::string command = "cyclictest -q -t 1 -p 80 -a " + std::to_string(options.cpu) + " -i " +
                              std::to_string(std::lround(period_s * 1e6)) + " -D " +
                              std::to_string(std::lround(options.seconds)) + " 2>/dev/null | tail -n 1";
  const std::string answer = Shell(command);
  return answer.empty() ? "cyclictest: not found; apt-get install rt-tests\n" : "cyclictest " + answer;
}

Pair Run(const Options& options, const Setting& setting) {
  const auto period_ns = std::llround(setting.period_s * 1e9);
  const render::RealtimeConfig realtime{.priority = 80, .cpu = options.cpu};
  WatchedClock whole_clock(period_ns, setting.spin_ns);
  WatchedClock bare_clock(period_ns);
  Pair pair;
  ServerRig rig(whole_clock, setting.period_s, realtime);
  std::optional<Overload> overload;
  if (setting.overload) {
    overload.emplace(rig.address());
  } else {
    rig.Render();
  }
  const BareLoop bare(bare_clock, whole_clock.deadline_ns() + period_ns / 2, period_ns, realtime);
  std::this_thread::sleep_for(std::chrono::duration<double>(options.warm_up_s));
  auto cyclictest = std::async(std::launch::async, [&] {
    return setting.cyclictest ? Cyclictest(options, setting.period_s) : std::string();
  });
  auto whole = std::async(std::launch::async, [&] { return whole_clock.Watch(options.seconds); });
  pair.bare = bare_clock.Watch(options.seconds);
  pair.whole = whole.get();
  pair.cyclictest = cyclictest.get();
  pair.rendering = rig.Status().state == exchange::State::kRendering;
  if (overload) {
    pair.overload = overload->End();
  }
  pair.samples_dropped_by_the_loop = rig.dropped_samples();
  return pair;
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

double Microseconds(int64_t ns) { return static_cast<double>(ns) / 1e3; }

void PrintRow(const char* name, const Watched& watched) {
  std::printf(
      "    %-6s lag p50 %8.1f us  p99 %8.1f us  p99.9 %8.1f us  max %8.1f us  missed %llu  CPU a tick %6.2f "
      "us"
      "  page faults %lld  involuntary switches %lld  heap calls %llu\n",
      name, Microseconds(watched.lag.p50_ns), Microseconds(watched.lag.p99_ns),
      Microseconds(watched.lag.p999_ns), Microseconds(watched.lag.max_ns),
      static_cast<unsigned long long>(watched.missed), watched.CpuPerTickNs() / 1e3,
      static_cast<long long>(watched.usage.page_faults),
      static_cast<long long>(watched.usage.involuntary_switches),
      static_cast<unsigned long long>(watched.usage.heap_calls));
}

double Ratio(int64_t whole, int64_t bare) { return static_cast<double>(whole) / static_cast<double>(bare); }

// The medians of the rounds, as ratios.
void PrintRatios(const std::vector<Pair>& pairs) {
  std::vector<double> p50;
  std::vector<double> p99;
  std::vector<double> cpu;
  for (const Pair& pair : pairs) {
    p50.push_back(Ratio(pair.whole.lag.p50_ns, pair.bare.lag.p50_ns));
    p99.push_back(Ratio(pair.whole.lag.p99_ns, pair.bare.lag.p99_ns));
    cpu.push_back(pair.whole.CpuPerTickNs() / pair.bare.CpuPerTickNs());
  }
  std::printf("  whole / bare, median of %zu rounds: p50 %.3f  p99 %.3f  CPU a tick %.3f\n", pairs.size(),
              Median(p50), Median(p99), Median(cpu));
}

void Overloaded(const Options& options) {
  std::printf("Under overload, 1 kHz: 256 streams, a storm of SetMass, a busy disk\n");
  std::vector<Pair> pairs;
  for (int round = 0; round < options.rounds; ++round) {
    const Pair pair = Run(options, {.overload = true, .cyclictest = true});
    std::printf(
        "  round %d: %llu streams, %llu samples in %llu batches, %llu not delivered, %llu lost by the loop; "
        "%llu masses set; %llu MB written; %s%s\n",
        round + 1, static_cast<unsigned long long>(pair.overload.streams),
        static_cast<unsigned long long>(pair.overload.samples),
        static_cast<unsigned long long>(pair.overload.batches),
        static_cast<unsigned long long>(pair.overload.lost),
        static_cast<unsigned long long>(pair.samples_dropped_by_the_loop),
        static_cast<unsigned long long>(pair.overload.masses_set),
        static_cast<unsigned long long>(pair.overload.megabytes_written),
        pair.rendering ? "rendering to the end" : "NOT RENDERING", pair.overload.error.c_str());
    PrintRow("bare", pair.bare);
    PrintRow("whole", pair.whole);
    std::printf("    %s", pair.cyclictest.c_str());
    pairs.push_back(pair);
  }
  PrintRatios(pairs);
}

void Idle(const Options& options, const char* title, int64_t spin_ns) {
  std::printf("%s\n", title);
  std::vector<Pair> pairs;
  for (int round = 0; round < options.rounds; ++round) {
    pairs.push_back(Run(options, {.spin_ns = spin_ns}));
    PrintRow("bare", pairs.back().bare);
    PrintRow("whole", pairs.back().whole);
  }
  PrintRatios(pairs);
}

// Off, on, and then the other way round, so that a drift of the host favours neither.
void KeepAwake(const Options& options) {
  std::printf("Keeping CPUs awake, 1 kHz, a server at rest: p99 of the bare loop without / with\n");
  std::vector<double> gains;
  for (int round = 0; round < options.rounds; ++round) {
    std::array<double, 2> p99{};
    for (int i = 0; i < 2; ++i) {
      const bool awake = (i + round) % 2 == 1;
      std::optional<render::WakefulCpus> wakeful;
      if (awake) {
        wakeful.emplace(std::vector<int>{});
        if (!wakeful->refusal().empty()) {
          std::printf("  refused: %s\n", wakeful->refusal().c_str());
          return;
        }
      }
      const Pair pair = Run(options, {});
      p99.at(awake ? 1 : 0) = Microseconds(pair.bare.lag.p99_ns);
    }
    std::printf("  round %d: %.1f us / %.1f us\n", round + 1, p99[0], p99[1]);
    gains.push_back(p99[0] / p99[1]);
  }
  std::printf("  median %.2f\n", Median(gains));
}

void HighestRate(const Options& options) {
  std::printf("Rates of the paper's tick, a server at rest: ticks missed in %.0f s\n", options.seconds);
  for (const double rate_hz : {1000.0, 2000.0, 4000.0, 5000.0, 8000.0, 10'000.0}) {
    const Pair pair = Run(options, {.period_s = 1 / rate_hz});
    std::printf("  %6.0f Hz: bare %llu, whole %llu of %llu%s\n", rate_hz,
                static_cast<unsigned long long>(pair.bare.missed),
                static_cast<unsigned long long>(pair.whole.missed),
                static_cast<unsigned long long>(pair.whole.ticks), pair.rendering ? "" : " (fault: overrun)");
  }
}

int Main(int argc, char** argv) {
  Options options;
  CLI::App app{"Compares the rendering loop with one that only sleeps, on one CPU, half a period apart"};
  app.add_option("--rounds", options.rounds, "Rounds of each comparison")->capture_default_str();
  app.add_option("--seconds", options.seconds, "Length of a round")->capture_default_str();
  app.add_option("--cpu", options.cpu, "CPU of both loops")->capture_default_str();
  app.add_option("--overload", options.overload)->group("");
  CLI11_PARSE(app, argc, argv);
  if (!options.overload.empty()) {
    return RunOverload(options.overload);
  }
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  Overloaded(options);
  Idle(options, "A server at rest, 1 kHz", 0);
  Idle(options, "Spinning for the last 200 us before a deadline, 1 kHz, a server at rest", 200'000);
  KeepAwake(options);
  HighestRate(options);
  return 0;
}

}  // namespace
}  // namespace mwidth::bench

int main(int argc, char** argv) { return mwidth::bench::Main(argc, argv); }
