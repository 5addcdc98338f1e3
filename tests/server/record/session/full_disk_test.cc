// A disk that is filled to its last byte while a session is recorded.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include <fcntl.h>
#include <sys/mount.h>
#include <unistd.h>

#include "server/record/session/session_reader.h"
#include "server/record/session/session_writer.h"
#include "tests/server/record/session/recording.h"

namespace mwidth::record {
namespace {

using exchange::Sample;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class FullDiskTest : public testing::Test {
 protected:
  void SetUp() override {
    if (mount("tmpfs", folder_.path().c_str(), "tmpfs", 0, "size=4m") != 0) {
      std::printf("skipped: a small file system cannot be mounted here (%s)\n", std::strerror(errno));
      GTEST_SKIP() << "a small file system cannot be mounted here (" << std::strerror(errno)
                   << "): run as root, with CAP_SYS_ADMIN";
    }
    mounted_ = true;
  }
  void TearDown() override {
    if (mounted_) {
      umount2(folder_.path().c_str(), MNT_DETACH);
    }
  }

  NewSession Create() {
    SessionInfo info = InfoOf(arm_.axis());
    info.labels.run = 0;
    return store_.Create(info);
  }
  SessionWriter Begin() {
    NewSession session = Create();
    path_ = session.path;
    now_ns_ = session.info.start_monotonic_ns;
    wall_offset_ns_ = session.info.start_wall_ns - now_ns_;
    return SessionWriter(
        std::move(session), 1, std::nullopt, 500,
        [this](EventKind kind, const std::string& message,
               const std::map<std::string, std::string>& metadata) {
          reported_.push_back(kind);
          messages_.push_back(message);
          disk_full_ = disk_full_ || (metadata.contains("disk_full") && metadata.at("disk_full") == "true");
        },
        {.wall_ns = [this] { return now_ns_ + wall_offset_ns_; },
         .monotonic_ns = [this] { return now_ns_; }});
  }
  // 50 ticks and a step, as the server does it; what was kept of them, if the disk took it.
  void Record(SessionWriter& writer) {
    const std::vector<Sample> samples = arm_.Take(50);
    all_.insert(all_.end(), samples.begin(), samples.end());
    writer.Offer(std::make_shared<const SampleBlock>(samples));
    writer.Step();
    if (++steps_ % 10 == 0) {
      writer.Sync();
    }
    now_ns_ += 50'000'000;
  }
  // Takes what is free, to the last byte.
  void Fill() {
    const int file = open((folder_ / "filler").c_str(), O_CREAT | O_WRONLY | O_APPEND, 0600);
    ASSERT_GE(file, 0);
    std::vector<char> bytes(65536, 'x');
    for (std::size_t size = bytes.size(); size > 0;) {
      size = write(file, bytes.data(), size) < 0 ? size / 2 : size;
    }
    close(file);
  }
  void MakeRoom() { std::filesystem::remove(folder_ / "filler"); }

  // The samples in the file, which is sound.
  std::vector<Sample> Stored() {
    SessionReader reader(path_);
    EXPECT_THAT(reader.Verify(), IsEmpty());
    std::vector<Sample> stored;
    std::vector<Sample> block;
    while (reader.Next(block)) {
      stored.insert(stored.end(), block.begin(), block.end());
    }
    return stored;
  }

  TemporaryFolder folder_;
  bool mounted_ = false;
  SwingingArm arm_;
  SessionStore store_{folder_.path(), 0};
  std::filesystem::path path_;
  int64_t now_ns_ = 0;
  int64_t wall_offset_ns_ = 0;
  int steps_ = 0;
  std::vector<Sample> all_;
  std::vector<EventKind> reported_;
  std::vector<std::string> messages_;
  bool disk_full_ = false;
};

TEST_F(FullDiskTest, KeepsWhatItHasTellsItRefusesNewSessionsAndGoesOnWhenThereIsRoom) {
  SessionWriter writer = Begin();
  for (int i = 0; i < 200; ++i) {
    Record(writer);
  }
  ASSERT_THAT(reported_, IsEmpty());
  Fill();
  const std::size_t before = all_.size();
  for (int i = 0; i < 400; ++i) {
    Record(writer);
  }
  ASSERT_THAT(reported_, ElementsAre(EventKind::kStorageFailed));
  EXPECT_TRUE(disk_full_);
  EXPECT_THAT(messages_[0], HasSubstr("make room"));
  const std::vector<Sample> kept = Stored();
  EXPECT_GE(kept.size(), before);
  EXPECT_TRUE(SameSamples(kept, {all_.begin(), all_.begin() + static_cast<std::ptrdiff_t>(kept.size())}));
  try {
    Create();
    ADD_FAILURE() << "a session began on a full disk";
  } catch (const SessionRefused& refused) {
    EXPECT_EQ(refused.reason(), SessionRefusal::kStorageFull) << refused.what();
  }
  EXPECT_EQ(store_.List().size(), 1) << "nothing is left of it";

  MakeRoom();
  now_ns_ += SessionWriter::kRetryNs;
  for (int i = 0; i < 100; ++i) {
    Record(writer);
  }
  EXPECT_EQ(reported_[1], EventKind::kStorageRestored);
  EXPECT_EQ(reported_[2], EventKind::kSamplesDropped);
  EXPECT_EQ(reported_.size(), 3);
  EXPECT_EQ(writer.End().state, SessionState::kEnded);
  const std::vector<Sample> stored = Stored();
  uint64_t lost = 0;
  for (const Gap& gap : SessionReader(path_).Gaps()) {
    lost += gap.lost_ticks;
    if (gap.lost_ticks > 0) {
      EXPECT_THAT(gap.reason, HasSubstr("storage failed"));
    }
  }
  EXPECT_EQ(stored.size() + lost, all_.size()) << "every sample is in the file, or in a gap";
  EXPECT_GT(lost, 10'000);
}

TEST_F(FullDiskTest, IsRecoveredAfterItsServerDiedOnAFullDisk) {
  {
    SessionWriter writer = Begin();
    for (int i = 0; i < 50; ++i) {
      Record(writer);
    }
    Fill();
    for (int i = 0; i < 400; ++i) {
      Record(writer);
    }
    ASSERT_THAT(reported_, ElementsAre(EventKind::kStorageFailed));
  }
  const std::size_t kept = Stored().size();
  EXPECT_GE(kept, 2500);
  store_.RecoverAll();  // as the disk allows
  MakeRoom();
  store_.RecoverAll();
  EXPECT_EQ(SessionReader(path_).info().state, SessionState::kRecovered);
  EXPECT_EQ(Stored().size(), kept);
}

}  // namespace
}  // namespace mwidth::record
