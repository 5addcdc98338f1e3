// `mwidth stream`, run against a server that answers as mwidthd does.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/client/fake_server.h"
#include "tests/client/subprocess.h"

namespace mwidth::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    lines.push_back(line);
  }
  return lines;
}

std::string Read(const std::filesystem::path& path) {
  std::ostringstream content;
  content << std::ifstream(path).rdbuf();
  return content.str();
}

class StreamTest : public ::testing::Test {
 protected:
  Outcome Run(std::vector<std::string> arguments, const std::function<void(int)>& meanwhile = {}) {
    arguments.insert(arguments.begin(), "stream");
    return RunProgram(MWIDTH_PROGRAM, arguments, server_.address(), meanwhile);
  }

  FakeServer server_;
};

TEST_F(StreamTest, CsvOfMinMaxHasTheExtremesBehindTheOtherColumns) {
  const auto outcome =
      Run({"--csv", "--samples", "1", "--decimation", "10", "--reduction", "min-max", "--min-batch", "5"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const auto lines = Lines(outcome.out);
  ASSERT_EQ(lines.size(), 2);
  EXPECT_THAT(lines[0],
              HasSubstr(",acceleration_counts,position_min_rad,position_max_rad,velocity_min_rad_per_s,"
                        "velocity_max_rad_per_s,acceleration_min_rad_per_s2,acceleration_max_rad_per_s2,"
                        "force_min_n_m,force_max_n_m"));
  EXPECT_THAT(lines[1], ::testing::EndsWith(",-7,1000,1001,-2,-1,1,2,0,0.5"));
}

TEST_F(StreamTest, RefusesAnUnknownReductionAndABatchOutOfRange) {
  for (const auto& arguments : {std::vector<std::string>{"--reduction", "mean"}, {"--min-batch", "1001"}}) {
    EXPECT_EQ(Run(arguments).code, 2);
  }
}

TEST_F(StreamTest, CsvHasUnitsInItsHeadAndExactNumbers) {
  const auto outcome = Run({"--csv", "--samples", "2"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(
      outcome.out,
      "tick,monotonic_ns,position_rad,velocity_rad_per_s,acceleration_rad_per_s2,force_n_m,mass_kg_m2,state,"
      "saturated,position_counts,force_counts,acceleration_counts\n"
      "1000,1000000000,333.33333333333331,-1,2,0.10000000000000001,0.050000000000000003,rendering,0,-1000,"
      "12,-7\n"
      "1001,1001000000,333.66666666666669,-1,2,0.10000000000000001,0.050000000000000003,rendering,1,-1001,"
      "12,-7\n");
}

TEST_F(StreamTest, SamplesCountExactlyAndGapsAreReported) {
  const auto outcome = Run({"--csv", "-", "--samples", "333"});
  EXPECT_EQ(Lines(outcome.out).size(), 334u);
  // Batches of 50 samples: 50 ms at 1 kHz.
  EXPECT_THAT(outcome.err, HasSubstr("gap before tick 1105: 2 ticks missed by the loop, 3 not delivered\n"));
  EXPECT_THAT(outcome.err, HasSubstr("333 samples; 2 ticks missed by the loop, 3 not delivered\n"));
}

TEST_F(StreamTest, SecondsAreThoseOfTheLoop) {
  const auto outcome = Run({"--csv", "--seconds", "0.02"});
  EXPECT_EQ(Lines(outcome.out).size(), 21u);
}

TEST_F(StreamTest, DecimationStepsTheTicks) {
  const auto lines = Lines(Run({"--csv", "--samples", "2", "--decimation", "25"}).out);
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_THAT(lines[1], StartsWith("1000,"));
  EXPECT_THAT(lines[2], StartsWith("1025,"));
}

TEST_F(StreamTest, CsvGoesToAFile) {
  const auto path =
      std::filesystem::temp_directory_path() / ("mwidth_stream_" + std::to_string(getpid()) + ".csv");
  const auto outcome = Run({"--csv", path.string(), "--samples", "5"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(Lines(Read(path)).size(), 6u);
  std::filesystem::remove(path);
}

TEST_F(StreamTest, AFileThatCannotBeWrittenIsAFailure) {
  const auto missing = Run({"--csv", "/nonexistent/reach.csv", "--samples", "5"});
  EXPECT_EQ(missing.code, 3);
  EXPECT_THAT(missing.err, HasSubstr("cannot write /nonexistent/reach.csv: No such file or directory"));
  const auto full = Run({"--csv", "/dev/full", "--samples", "5"});
  EXPECT_EQ(full.code, 3);
  EXPECT_THAT(full.err, HasSubstr("No space left on device"));
}

TEST_F(StreamTest, TheTableShowsTenRowsASecond) {
  const auto outcome = Run({"--samples", "3"});
  const auto lines = Lines(outcome.out);
  ASSERT_EQ(lines.size(), 5u);
  EXPECT_THAT(lines[0], AllOf(HasSubstr("time"), HasSubstr("position"), HasSubstr("state")));
  EXPECT_THAT(lines[1], AllOf(HasSubstr("rad/s²"), HasSubstr("N m"), HasSubstr("kg m²")));
  EXPECT_THAT(lines[2], AllOf(HasSubstr("333.333"), HasSubstr("rendering")));
  EXPECT_THAT(lines[3], HasSubstr("      0.1"));
}

TEST_F(StreamTest, JsonIsOneBatchALine) {
  const auto outcome = Run({"--json", "--samples", "60"});
  const auto lines = Lines(outcome.out);
  ASSERT_EQ(lines.size(), 2u);
  const auto batch = nlohmann::json::parse(lines[0]);
  EXPECT_EQ(batch["first_tick"], "1000");
  EXPECT_EQ(batch["position"].size(), 50u);
  EXPECT_EQ(batch["force_counts"][0], 12);
}

TEST_F(StreamTest, CtrlCEndsItWithTheSummary) {
  const auto path =
      std::filesystem::temp_directory_path() / ("mwidth_endless_" + std::to_string(getpid()) + ".csv");
  const auto outcome = Run({"--csv", path.string()}, [&](int pid) {
    // The summary tells of the missed ticks only once the batch behind them has come.
    while (Read(path).find("\n1105,") == std::string::npos) {
    }
    kill(pid, SIGINT);
  });
  std::filesystem::remove(path);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("samples; 2 ticks missed"));
}

TEST_F(StreamTest, AReaderThatGoesAwayEndsItQuietly) {
  const auto outcome =
      RunProgram("/bin/bash", {"-c", MWIDTH_PROGRAM " stream --csv | head -n 3; exit ${PIPESTATUS[0]}"},
                 server_.address());
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(Lines(outcome.out).size(), 3u);
  EXPECT_THAT(outcome.err, Not(HasSubstr("mwidth:")));
}

TEST_F(StreamTest, AnEndByTheServerIsAFailure) {
  server_.Behave({.end_stream_after_batches = 2});
  const auto outcome = Run({"--csv"});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_EQ(Lines(outcome.out).size(), 101u);
  EXPECT_THAT(outcome.err, HasSubstr("the server shuts down"));
}

}  // namespace
}  // namespace mwidth::testing
