// Charts and tables as files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "client/cli/plot/chart.h"
#include "client/cli/plot/csv_file.h"
#include "client/cli/plot/table.h"

namespace mwidth::plot {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string Contents(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

// Two panels of which the lower has a gap and negative values beneath a logarithmic one.
Chart SmallChart() {
  const Curve rising{.name = "rising", .x = {1, 2}, .y = {0.1, 10}};
  const Curve gap{.name = "gap", .x = {1, 2, 3}, .y = {-1, std::numeric_limits<double>::quiet_NaN(), -3}};
  return {.title = "it's a title",
          .x = {.label = "Cut-off, Hz", .column = "cutoff_hz"},
          .panels = {{.y = {.label = "a", .column = "a", .logarithmic = true}, .curves = {rising}},
                     {.y = {.label = "b", .column = "b", .min = -4}, .curves = {gap}}},
          .gap = "unstable"};
}

class PlotTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_);
    // As main does: a gnuplot that is missing must not end the program.
    ASSERT_NE(std::signal(SIGPIPE, SIG_IGN), SIG_ERR);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // With what a shell or gnuplot could stumble over.
  std::filesystem::path folder_ = std::filesystem::path(::testing::TempDir()) / "it's a $(plot)";
};

TEST_F(PlotTest, AChartsDataKeepsEveryDigitAndNamesItsGaps) {
  WriteCsv(SmallChart(), folder_ / "chart.csv");
  EXPECT_EQ(Contents(folder_ / "chart.csv"),
            "quantity,curve,cutoff_hz,value\n"
            "a,rising,1,0.10000000000000001\n"
            "a,rising,2,10\n"
            "b,gap,1,-1\n"
            "b,gap,2,unstable\n"
            "b,gap,3,-3\n");
}

TEST_F(PlotTest, CellsWithCommasAndQuotesAreQuoted) {
  CsvFile csv(folder_ / "cells.csv");
  csv.Row({"a,b", "say \"no\"", ""});
  csv.Close();
  EXPECT_EQ(Contents(folder_ / "cells.csv"), "\"a,b\",\"say \"\"no\"\"\",\n");
}

TEST_F(PlotTest, TheExtensionChoosesThePicture) {
  Draw(SmallChart(), folder_ / "chart.svg");
  EXPECT_THAT(Contents(folder_ / "chart.svg"), HasSubstr("</svg>"));
  EXPECT_THAT(Contents(folder_ / "chart.svg"), HasSubstr("it's a title"));
  Draw(SmallChart(), folder_ / "chart.png");
  EXPECT_THAT(Contents(folder_ / "chart.png"), StartsWith("\x89PNG"));
  EXPECT_THROW(Draw(SmallChart(), folder_ / "chart.pdf"), std::runtime_error);
}

TEST_F(PlotTest, ATableIsAlignedByCharactersNotBytes) {
  const Table table{.title = "t", .columns = {"name", "value"}, .rows = {{"ω_n", "1"}, {"m", "2"}}};
  EXPECT_EQ(ToText(table), "name  value\nω_n   1\nm     2\n");
  WriteCsv(table, folder_ / "table.csv");
  EXPECT_EQ(Contents(folder_ / "table.csv"), "name,value\nω_n,1\nm,2\n");
  Draw(table, folder_ / "table.svg");
  EXPECT_THAT(Contents(folder_ / "table.svg"), HasSubstr("ω_n"));
}

TEST_F(PlotTest, AFileThatCannotBeWrittenIsNamed) {
  const auto missing = folder_ / "missing" / "x.csv";
  try {
    WriteCsv(SmallChart(), missing);
    FAIL() << "wrote " << missing;
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), EndsWith(missing.string()));
  }
  EXPECT_THROW(Draw(SmallChart(), folder_ / "missing" / "x.svg"), std::runtime_error);
}

TEST_F(PlotTest, WithoutGnuplotThePackageIsNamed) {
  const std::string path = std::getenv("PATH");
  ASSERT_EQ(setenv("PATH", folder_.c_str(), 1), 0);
  std::string message;
  try {
    Draw(SmallChart(), folder_ / "chart.svg");
  } catch (const std::runtime_error& error) {
    message = error.what();
  }
  ASSERT_EQ(setenv("PATH", path.c_str(), 1), 0);
  EXPECT_THAT(message, HasSubstr("gnuplot-nox"));
}

}  // namespace
}  // namespace mwidth::plot
