#include "server/record/export/file_set.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <sstream>
#include <system_error>

#include "tests/support/temporary_folder.h"

namespace mwidth::record {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

std::string Read(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

class FileSetTest : public ::testing::Test {
 protected:
  size_t Count() const {
    return static_cast<size_t>(
        std::distance(fs::recursive_directory_iterator(folder_), fs::recursive_directory_iterator()));
  }

  const TemporaryFolder temporary_;
  const fs::path folder_ = temporary_.path();
};

TEST_F(FileSetTest, FilesAppearWithTheCommit) {
  FileSet files(false);
  const fs::path file = folder_ / "a" / "b" / "one.txt";
  WriteText(files.Add(file), "one");
  WriteText(files.Add(folder_ / "two.txt"), "two");
  EXPECT_FALSE(fs::exists(file));
  files.Commit();
  EXPECT_EQ(Read(file), "one");
  EXPECT_EQ(Read(folder_ / "two.txt"), "two");
  EXPECT_EQ(files.Paths(), (std::vector<fs::path>{file, folder_ / "two.txt"}));
  // Two folders, two files, and nothing else.
  EXPECT_EQ(Count(), 4u);
}

TEST_F(FileSetTest, WithoutACommitNothingStays) {
  {
    FileSet files(false);
    WriteText(files.Add(folder_ / "a" / "b" / "one.txt"), "one");
  }
  EXPECT_EQ(Count(), 0u);
}

TEST_F(FileSetTest, WithoutACommitFoldersOfOthersStay) {
  fs::create_directory(folder_ / "a");
  {
    FileSet files(false);
    WriteText(files.Add(folder_ / "a" / "b" / "one.txt"), "one");
    WriteText(folder_ / "a" / "theirs.txt", "theirs");
  }
  EXPECT_EQ(Count(), 2u);
}

TEST_F(FileSetTest, WhatIsThereIsNotReplaced) {
  const fs::path file = folder_ / "one.txt";
  WriteText(file, "old");
  FileSet files(false);
  try {
    files.Add(file);
    FAIL() << "was taken";
  } catch (const ExportRefused& refusal) {
    EXPECT_THAT(refusal.what(), HasSubstr("one.txt exists already; --force"));
  }
  EXPECT_EQ(Read(file), "old");
}

TEST_F(FileSetTest, WhatOthersMadeMeanwhileIsNotReplaced) {
  const fs::path file = folder_ / "one.txt";
  FileSet files(false);
  WriteText(files.Add(file), "new");
  WriteText(file, "theirs");
  EXPECT_THROW(files.Commit(), ExportRefused);
  EXPECT_EQ(Read(file), "theirs");
}

TEST_F(FileSetTest, OverwritingAndReplacingDo) {
  WriteText(folder_ / "one.txt", "old");
  WriteText(folder_ / "table.tsv", "old");
  FileSet overwriting(true);
  WriteText(overwriting.Add(folder_ / "one.txt"), "new");
  overwriting.Commit();
  EXPECT_EQ(Read(folder_ / "one.txt"), "new");
  FileSet careful(false);
  WriteText(careful.Replace(folder_ / "table.tsv"), "new");
  careful.Commit();
  EXPECT_EQ(Read(folder_ / "table.tsv"), "new");
}

TEST_F(FileSetTest, AFailedWriteIsToldWithItsFile) {
  // /dev/full takes nothing.
  TextFile full("/dev/full");
  try {
    full.Write(std::string(1 << 20, 'x'));
    full.Close();
    FAIL() << "was written";
  } catch (const std::system_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("cannot write /dev/full"));
    EXPECT_EQ(error.code(), std::errc::no_space_on_device);
  }
  TextFile late("/dev/full");
  late.Write("x");
  EXPECT_THROW(late.Close(), std::system_error);
  EXPECT_THROW(TextFile(folder_ / "none" / "one.txt"), std::system_error);
}

}  // namespace
}  // namespace mwidth::record
