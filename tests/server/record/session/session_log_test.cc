// Disks that fail to sync, which the system tells once.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <filesystem>
#include <vector>

#include <sys/syscall.h>
#include <unistd.h>

#include "server/record/session/session_file.h"
#include "server/record/session/session_reader.h"
#include "tests/server/record/session/failing_disk.h"
#include "tests/server/record/session/recording.h"

namespace {

std::atomic<int> failing_syncs = 0;
std::atomic<int> sync_error = EIO;

}  // namespace

// In place of the system's, for SQLite too.
extern "C" int fdatasync(int file) {
  if (failing_syncs > 0 && failing_syncs-- > 0) {
    errno = sync_error;
    return -1;
  }
  return static_cast<int>(syscall(SYS_fdatasync, file));
}

namespace mwidth::record {
namespace {

using testing::IsEmpty;

class SessionLogTest : public testing::Test {
 protected:
  void TearDown() override { failing_syncs = 0; }
  void Commit(int ticks) {
    session_.Append(arm_.Take(ticks), "lost");
    session_.Commit(Durability::kProcess);
    committed_ += static_cast<uint64_t>(ticks);
  }
  // What the file has without its log.
  uint64_t SamplesByItself() const {
    const auto copy = folder_ / "copy.sqlite";
    std::filesystem::copy_file(file_, copy, std::filesystem::copy_options::overwrite_existing);
    SessionReader reader(copy);
    EXPECT_THAT(reader.Verify(), IsEmpty());
    return reader.info().sample_count;
  }
  bool SyncFails() {
    try {
      session_.Sync();
    } catch (const StorageError& error) {
      disk_full_ = error.disk_full();
      return true;
    }
    return false;
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "session.sqlite";
  SwingingArm arm_;
  SessionFile session_{file_, InfoOf(arm_.axis())};
  uint64_t committed_ = 0;
  bool disk_full_ = false;
};

TEST_F(SessionLogTest, IsHealedOnlyByWritingAllOfItAgain) {
  Commit(500);
  session_.Sync();
  Commit(500);
  failing_syncs = 1;
  EXPECT_TRUE(SyncFails());
  EXPECT_FALSE(disk_full_);
  Commit(500);
  EXPECT_FALSE(SyncFails());
  EXPECT_EQ(SamplesByItself(), committed_) << "the database was written from what is cached";
  EXPECT_EQ(std::filesystem::file_size(file_.string() + "-wal"), 0) << "and the log begun anew";
  Commit(500);
  session_.End(SessionState::kEnded, 0);
  EXPECT_EQ(SessionReader(file_).info().sample_count, committed_);
  EXPECT_THAT(SessionReader(file_).Verify(), IsEmpty());
}

TEST_F(SessionLogTest, StaysFailedUntilThatWorks) {
  Commit(5000);
  failing_syncs = 1;
  EXPECT_TRUE(SyncFails());
  {
    const NoFileGrows failing;
    EXPECT_TRUE(SyncFails()) << "the log's sync would work now";
    EXPECT_TRUE(SyncFails());
  }
  EXPECT_FALSE(SyncFails());
  EXPECT_EQ(SamplesByItself(), committed_);
}

TEST_F(SessionLogTest, TellsADiskWithoutRoom) {
  Commit(50);
  failing_syncs = 1;
  sync_error = ENOSPC;
  EXPECT_TRUE(SyncFails());
  EXPECT_TRUE(disk_full_);
  sync_error = EIO;
}

}  // namespace
}  // namespace mwidth::record
