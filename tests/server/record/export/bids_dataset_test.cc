#include "server/record/export/bids_dataset.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "server/record/export/file_set.h"
#include "tests/support/temporary_folder.h"

namespace mwidth::record {
namespace {

namespace fs = std::filesystem;

class BidsDatasetTest : public ::testing::Test {
 protected:
  fs::path File(const std::string& text) const {
    WriteText(folder_ / "file", text);
    return folder_ / "file";
  }

  const TemporaryFolder temporary_;
  const fs::path folder_ = temporary_.path();
};

TEST_F(BidsDatasetTest, ATableBeginsWithItsColumns) {
  auto table = BidsTable::Read(folder_ / "none.tsv", {"filename", "acq_time"});
  EXPECT_EQ(table.Text(), "filename\tacq_time\n");
  table.Set({{"filename", "a"}, {"acq_time", "1"}});
  table.Set({{"filename", "b"}});
  EXPECT_EQ(table.Text(), "filename\tacq_time\na\t1\nb\tn/a\n");
}

TEST_F(BidsDatasetTest, ATableKeepsWhatItDoesNotKnow) {
  auto table =
      BidsTable::Read(File("\xEF\xBB\xBFoperator\tfilename\r\nA B\ta\r\n\"x\ty\n"), {"filename", "acq_time"});
  table.Set({{"filename", "a"}, {"acq_time", "2"}});
  EXPECT_EQ(table.Text(), "operator\tfilename\tacq_time\nA B\ta\t2\n\"x\ty\tn/a\n");
}

TEST_F(BidsDatasetTest, ATableThatIsNoneIsRefused) {
  EXPECT_THROW(BidsTable::Read(File(""), {"filename"}), ExportRefused);
  EXPECT_THROW(BidsTable::Read(File("name\tage\n"), {"filename"}), ExportRefused);
  EXPECT_THROW(BidsTable::Read(File("filename\tage\na\n"), {"filename"}), ExportRefused);
}

TEST_F(BidsDatasetTest, ADescriptionHasWhatTheStandardRequires) {
  const auto json = nlohmann::json::parse(DatasetDescription(folder_ / "none.json", "reaches"));
  EXPECT_EQ(json["Name"], "reaches");
  EXPECT_EQ(json["BIDSVersion"], "1.9.0");
  EXPECT_EQ(json["DatasetType"], "raw");
  EXPECT_EQ(json["GeneratedBy"][0]["Name"], "mwidth");
}

TEST_F(BidsDatasetTest, ADescriptionKeepsWhatItHasAndNamesThisProgramOnce) {
  const auto file =
      File(R"({"Name": "A study", "BIDSVersion": "1.10.0", "GeneratedBy": [{"Name": "other"}], "x": 1})");
  const std::string once = DatasetDescription(file, "reaches");
  WriteText(file, once);
  EXPECT_EQ(DatasetDescription(file, "reaches"), once);
  const auto json = nlohmann::json::parse(once);
  EXPECT_EQ(json["Name"], "A study");
  EXPECT_EQ(json["BIDSVersion"], "1.10.0");
  EXPECT_EQ(json["x"], 1);
  EXPECT_EQ(json["GeneratedBy"].size(), 2u);
  EXPECT_EQ(json["GeneratedBy"][0]["Name"], "other");
}

TEST_F(BidsDatasetTest, ADescriptionThatIsNoneIsRefused) {
  EXPECT_THROW(DatasetDescription(File("{"), "reaches"), ExportRefused);
  EXPECT_THROW(DatasetDescription(File("[]"), "reaches"), ExportRefused);
  // Somebody else's mistakes in it are left to them.
  EXPECT_NO_THROW(DatasetDescription(File(R"({"GeneratedBy": [{"Name": 7}]})"), "reaches"));
}

}  // namespace
}  // namespace mwidth::record
