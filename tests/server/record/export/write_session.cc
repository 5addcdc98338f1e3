// Writes a session and, for those who read its exports, the same samples as plain bytes.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>

#include "tests/server/record/export/recorded_session.h"

namespace {

// Little-endian, packed; tests/integration/session_files_test.py has the same list of types.
class Truth {
 public:
  explicit Truth(const std::string& file) : out_(file, std::ios::binary) {}

  void Add(const mwidth::exchange::Sample& sample) {
    Put(sample.tick);
    Put(sample.monotonic_ns);
    for (const double value :
         {sample.position, sample.velocity, sample.acceleration, sample.force, sample.mass}) {
      Put(value);
    }
    Put(sample.state);
    Put(sample.saturated);
    Put(sample.position_counts);
    Put(sample.force_counts);
    Put(sample.acceleration_counts);
    Put(sample.slew_limited);
    Put(sample.position_stale);
    Put(sample.force_taken);
    Put(sample.missed_ticks);
    Put(sample.filter.estimator);
    Put(sample.filter.cutoff_hz);
  }
  bool Close() {
    out_.close();
    return static_cast<bool>(out_);
  }

 private:
  template <typename T>
  void Put(const T& value) {
    out_.write(reinterpret_cast<const char*>(&value), sizeof value);
  }
  std::ofstream out_;
};

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Writes a session as a server does.");
  std::string file;
  std::string truth_file;
  uint64_t seed = 1;
  uint64_t count = 10'000;
  bool linear = false;
  bool killed = false;
  app.add_option("file", file)->required();
  app.add_option("--truth", truth_file, "The samples as bytes");
  app.add_option("--seed", seed);
  app.add_option("--samples", count);
  app.add_flag("--linear", linear);
  app.add_flag("--killed", killed, "Leave it as a server that was killed does");
  // The labels, where they are not the usual ones.
  auto labels = mwidth::testing::MakeSession(1, 1, true).info.labels;
  app.add_option("--subject", labels.subject);
  app.add_option("--visit", labels.visit);
  app.add_option("--task", labels.task);
  app.add_option("--run", labels.run);
  CLI11_PARSE(app, argc, argv);

  auto session = mwidth::testing::MakeSession(seed, count, !linear);
  session.info.labels = labels;
  mwidth::testing::Write(session, file, !killed);
  if (truth_file.empty()) {
    return 0;
  }
  Truth truth(truth_file);
  for (const auto& sample : session.samples) {
    truth.Add(sample);
  }
  return truth.Close() ? 0 : 1;
}
