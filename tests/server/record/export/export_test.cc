// Exports where sessions are odd, or cannot be written. What they hold is read by tests/integration.
#include "server/record/export/export.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "server/record/session/session_file.h"
#include "tests/server/record/export/recorded_session.h"
#include "tests/support/temporary_folder.h"

namespace mwidth::record {
namespace {

namespace fs = std::filesystem;
using mwidth::testing::MakeSession;
using ::testing::HasSubstr;

class ExportTest : public ::testing::Test {
 protected:
  static std::string Read(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
  }

  const TemporaryFolder temporary_;
  const fs::path folder_ = temporary_.path();
};

TEST_F(ExportTest, ASessionWithoutSamplesIsExportedButAsBids) {
  { SessionFile(folder_ / "none.sqlite", MakeSession(1, 1, true).info); }
  SessionReader reader(folder_ / "none.sqlite");
  EXPECT_EQ(ExportCsv(reader, folder_ / "csv", false).samples, 0u);
  EXPECT_EQ(ExportHdf5(reader, folder_ / "none.h5", false).samples, 0u);
  EXPECT_THROW(ExportBids(reader, folder_ / "bids", false), ExportRefused);
  EXPECT_FALSE(fs::exists(folder_ / "bids"));
  EXPECT_THAT(Read(folder_ / "csv" / "session.json"), HasSubstr("\"state\": \"open\""));
}

TEST_F(ExportTest, ASessionOfOneSampleHasItsNominalFrequency) {
  Write(MakeSession(1, 1, true), folder_ / "one.sqlite");
  SessionReader reader(folder_ / "one.sqlite");
  const auto report = ExportBids(reader, folder_ / "bids", false);
  EXPECT_EQ(report.samples, 1u);
  const std::string json = Read(report.files[1]);
  EXPECT_THAT(json, HasSubstr("\"SamplingFrequencyEffective\": 1000.0"));
  EXPECT_THAT(json, HasSubstr("\"RecordingDuration\": 0.001"));
}

TEST_F(ExportTest, AReaderThatHasReadIsReadFromItsBeginning) {
  Write(MakeSession(3, 500, true), folder_ / "one.sqlite");
  SessionReader reader(folder_ / "one.sqlite");
  std::vector<exchange::Sample> samples;
  while (reader.Next(samples)) {
  }
  EXPECT_EQ(ExportCsv(reader, folder_ / "csv", false).samples, 500u);
  EXPECT_EQ(ExportHdf5(reader, folder_ / "one.h5", false).samples, 500u);
  EXPECT_EQ(ExportBids(reader, folder_ / "bids", false).samples, 500u);
}

TEST_F(ExportTest, ADatasetThatCannotBeMergedIntoIsLeftAsItIs) {
  Write(MakeSession(3, 500, true), folder_ / "one.sqlite");
  SessionReader reader(folder_ / "one.sqlite");
  fs::create_directory(folder_ / "bids");
  WriteText(folder_ / "bids" / "participants.tsv", "name\tage\n");
  EXPECT_THROW(ExportBids(reader, folder_ / "bids", true), ExportRefused);
  EXPECT_EQ(std::distance(fs::recursive_directory_iterator(folder_ / "bids"), {}), 1);
}

// Ends with 0 where the export fails as it should, in a process whose files end at 64 KiB.
[[noreturn]] void ExportWithoutRoom(SessionReader& reader, const fs::path& file) {
  std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{65536, 65536};
  setrlimit(RLIMIT_FSIZE, &limit);
  try {
    ExportHdf5(reader, file, false);
  } catch (const std::runtime_error& error) {
    std::exit(std::string(error.what()).starts_with("cannot write " + file.string()) ? 0 : 2);
  }
  std::exit(1);
}

TEST_F(ExportTest, Hdf5SurvivesADiskWithoutRoom) {
  Write(MakeSession(3, 20'000, true), folder_ / "one.sqlite");
  SessionReader reader(folder_ / "one.sqlite");
  // Its exit handlers run, too: there HDF5 would try again, and crash.
  EXPECT_EXIT(ExportWithoutRoom(reader, folder_ / "out" / "one.h5"), ::testing::ExitedWithCode(0), "");
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST_F(ExportTest, AFolderThatCannotBeWrittenIsNamed) {
  Write(MakeSession(3, 500, true), folder_ / "one.sqlite");
  SessionReader reader(folder_ / "one.sqlite");
  WriteText(folder_ / "file", "");
  EXPECT_THROW(ExportCsv(reader, folder_ / "file", false), std::runtime_error);
  EXPECT_THROW(ExportHdf5(reader, folder_ / "file" / "one.h5", false), std::runtime_error);
  EXPECT_THROW(ExportBids(reader, folder_ / "file", false), std::runtime_error);
  EXPECT_EQ(Read(folder_ / "file"), "");
}

}  // namespace
}  // namespace mwidth::record
