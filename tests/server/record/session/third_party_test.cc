// The reader that the README gives to everybody else, as it stands there.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "server/record/session/session_file.h"
#include "tests/server/record/session/recording.h"

namespace mwidth::record {
namespace {

using exchange::Sample;

std::string PythonOfTheReadme() {
  std::ifstream file(SESSION_README);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const std::string begin = "```python\n";
  const std::size_t from = text.find(begin) + begin.size();
  return text.substr(from, text.find("```", from) - from);
}

TEST(ThirdPartyTest, ReadsASessionByTheReadmeAlone) {
  const TemporaryFolder folder;
  const auto file = folder / "session.sqlite";
  SwingingArm arm;
  const std::vector<Sample> samples = arm.Take(10'000);
  SessionFile session(file, InfoOf(arm.axis()));
  for (std::size_t i = 0; i < samples.size(); i += 100) {
    session.Append({samples.data() + i, 100}, "");
    session.Commit(Durability::kProcess);
  }
  const auto program = folder / "read.py";
  std::ofstream(program) << PythonOfTheReadme();
  // Once as it is written, with a tail, and once when it is closed.
  for (int pass = 0; pass < 2; ++pass) {
    FILE* output = popen(("/usr/bin/python3 " + program.string() + " " + file.string()).c_str(), "r");
    ASSERT_NE(output, nullptr);
    std::size_t rows = 0;
    unsigned long long tick = 0;
    double time_s = 0;
    double position = 0;
    double force = 0;
    double mass = 0;
    while (std::fscanf(output, "%llu %lf %lf %lf %lf", &tick, &time_s, &position, &force, &mass) == 5) {
      ASSERT_LT(rows, samples.size());
      const Sample& sample = samples[rows++];
      ASSERT_EQ(tick, sample.tick);
      ASSERT_NEAR(time_s, static_cast<double>(sample.monotonic_ns) * 1e-9, 1e-9);
      ASSERT_EQ(force, sample.force);
      ASSERT_EQ(mass, sample.mass);
      ASSERT_TRUE(sample.position_stale || position == sample.position);
    }
    EXPECT_EQ(pclose(output), 0);
    EXPECT_EQ(rows, samples.size());
    if (pass == 0) {
      session.End(SessionState::kEnded, 0);
    }
  }
}

}  // namespace
}  // namespace mwidth::record
