#include "server/record/session/session_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <sys/stat.h>

#include "server/record/session/session_reader.h"
#include "tests/server/record/session/recording.h"

namespace mwidth::record {
namespace {

using exchange::Sample;
using testing::ElementsAre;
using testing::IsEmpty;

std::vector<Sample> ReadAll(SessionReader& reader) {
  std::vector<Sample> all;
  std::vector<Sample> block;
  while (reader.Next(block)) {
    all.insert(all.end(), block.begin(), block.end());
  }
  return all;
}

class SessionFileTest : public testing::Test {
 protected:
  // Appends and commits `ticks` samples in steps as a server would.
  void Record(int ticks) {
    while (ticks > 0) {
      const std::vector<Sample> samples = arm_.Take(std::min(ticks, 50));
      ticks -= 50;
      all_.insert(all_.end(), samples.begin(), samples.end());
      session_.Append(samples, "lost");
      session_.Commit(Durability::kProcess);
    }
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "sub-01_task-reach_run-02_20261122T063200Z.sqlite";
  SwingingArm arm_;
  SessionInfo info_ = InfoOf(arm_.axis());
  SessionFile session_{file_, info_};
  std::vector<Sample> all_;
};

TEST_F(SessionFileTest, HasWhatItSaysOfItself) {
  info_.axis.force_slew_limit = std::numeric_limits<double>::infinity();
  const auto file = folder_ / "other.sqlite";
  SessionFile other(file, info_);
  info_.id = "other";
  EXPECT_EQ(SessionReader(file).info(), info_);
  other.Append(arm_.Take(100), "lost");
  other.End(SessionState::kEnded, info_.start_wall_ns + 5);
  info_.state = SessionState::kEnded;
  info_.end_wall_ns = info_.start_wall_ns + 5;
  info_.sample_count = 100;
  info_.first_tick = 1;
  info_.last_tick = 102;
  EXPECT_EQ(SessionReader(file).info(), info_);
}

TEST_F(SessionFileTest, GivesBackEverySampleToTheBitAlsoWhileItIsWritten) {
  Record(3000);
  {
    SessionReader reader(file_);
    EXPECT_EQ(reader.info().state, SessionState::kOpen);
    EXPECT_TRUE(SameSamples(ReadAll(reader), all_)) << "all of it in the tail";
    Record(3000);
    EXPECT_TRUE(SameSamples(ReadAll(reader), std::vector<Sample>(all_.begin() + 3000, all_.end())))
        << "the same reader goes on where it was, although the tail became a block";
    EXPECT_THAT(reader.Verify(), IsEmpty());
  }
  session_.End(SessionState::kEnded, 0);
  SessionReader reader(file_);
  EXPECT_TRUE(SameSamples(ReadAll(reader), all_));
  EXPECT_THAT(reader.damaged(), IsEmpty());
  EXPECT_THAT(reader.Verify(), IsEmpty());
  EXPECT_FALSE(std::filesystem::exists(file_.string() + "-wal")) << "a single file";
  EXPECT_FALSE(std::filesystem::exists(file_.string() + "-shm"));
}

TEST_F(SessionFileTest, NotesEveryAbsentTick) {
  const std::vector<Sample> samples = arm_.Take(1000);
  uint64_t absent = 0;
  uint64_t missed = 0;
  std::mt19937_64 random(5);
  Sample last;
  std::vector<Sample> kept;
  for (const Sample& sample : samples) {
    if (random() % 20 == 0) {
      continue;
    }
    if (!kept.empty()) {
      absent += sample.tick - last.tick - 1;
      missed += sample.missed_ticks - last.missed_ticks;
    }
    kept.push_back(sample);
    last = sample;
    session_.Append({&sample, 1}, "the reason");
    if (random() % 30 == 0) {
      session_.Commit(Durability::kProcess);
    }
  }
  session_.End(SessionState::kEnded, 0);
  SessionReader reader(file_);
  EXPECT_TRUE(SameSamples(ReadAll(reader), kept));
  EXPECT_THAT(reader.Verify(), IsEmpty());
  uint64_t told_missed = 0;
  uint64_t told_lost = 0;
  for (const Gap& gap : reader.Gaps()) {
    told_missed += gap.missed_ticks;
    told_lost += gap.lost_ticks;
    EXPECT_EQ(gap.before_tick - gap.after_tick - 1, gap.missed_ticks + gap.lost_ticks);
    EXPECT_EQ(gap.reason == "the reason", gap.lost_ticks > 0);
  }
  EXPECT_EQ(told_missed, missed);
  EXPECT_EQ(told_lost, absent - missed);
  EXPECT_GT(told_lost, 0);
  EXPECT_GT(told_missed, 0);
}

TEST_F(SessionFileTest, PassesOverSamplesThatAreNotNew) {
  const std::vector<Sample> samples = arm_.Take(10);
  session_.Append(samples, "lost");
  session_.Append(samples, "lost");
  session_.Commit(Durability::kProcess);
  SessionReader reader(file_);
  EXPECT_TRUE(SameSamples(ReadAll(reader), samples));
}

TEST_F(SessionFileTest, KeepsEventsMarkersGapsAndSteps) {
  const Event event{.number = 7,
                    .kind = EventKind::kMassSet,
                    .tick = 12,
                    .monotonic_ns = -3,
                    .message = "mass set",
                    .metadata = {{"mass", "0.3"}}};
  const Event earlier{
      .number = 6, .kind = EventKind::kFault, .tick = 11, .monotonic_ns = -4, .message = "", .metadata = {}};
  const Marker marker{.number = 1,
                      .label = "go",
                      .kind = "trial_start",
                      .metadata = {{"target", "left"}},
                      .monotonic_ns = 5,
                      .error_ns = 6,
                      .arrival_ns = 7,
                      .client_ns = 8};
  const Gap gap{.after_tick = 40, .before_tick = 0, .missed_ticks = 1, .lost_ticks = 2, .reason = "why"};
  const WallClockStep step{.monotonic_ns = 9, .offset_ns = std::numeric_limits<int64_t>::max()};
  session_.Add(event);
  session_.Add(earlier);
  session_.Add(marker);
  session_.Add(gap);
  session_.Add(step);
  EXPECT_TRUE(session_.HasPending());
  session_.Commit(Durability::kPower);
  EXPECT_FALSE(session_.HasPending());
  const SessionReader reader(file_);
  EXPECT_THAT(reader.Events(), ElementsAre(earlier, event));
  EXPECT_THAT(reader.Markers(), ElementsAre(marker));
  EXPECT_THAT(reader.Gaps(), ElementsAre(gap));
  EXPECT_THAT(reader.WallClockSteps(), ElementsAre(step));
}

TEST_F(SessionFileTest, SeeksTheBlockThatHasATick) {
  Record(10000);
  for (int pass = 0; pass < 2; ++pass) {
    SessionReader reader(file_);
    std::vector<Sample> block;
    for (const uint64_t tick : {1U, 4096U, 4500U, 9000U, 10100U, 2U}) {
      reader.Seek(tick);
      ASSERT_TRUE(reader.Next(block));
      EXPECT_GE(block.back().tick, tick);
      if (tick > 4500) {
        EXPECT_GT(block.front().tick, 4000);
      }
    }
    EXPECT_EQ(block.front().tick, 1);
    reader.Seek(all_.back().tick + 1);
    EXPECT_FALSE(reader.Next(block));
    EXPECT_THAT(block, IsEmpty());
    session_.End(SessionState::kEnded, 0);
  }
}

TEST_F(SessionFileTest, IsWholeByItselfWhereItEndsUnderAReader) {
  Record(6000);
  const auto copy = folder_ / "copy.sqlite";
  {
    SessionReader reader(file_);
    std::vector<Sample> block;
    ASSERT_TRUE(reader.Next(block));
    session_.End(SessionState::kEnded, 0);
    std::filesystem::copy_file(file_, copy);  // what beside it is its log is left behind
    EXPECT_EQ(block.size() + ReadAll(reader).size(), 6000) << "its reader goes on";
  }
  SessionReader reader(copy);
  EXPECT_EQ(reader.info().state, SessionState::kEnded);
  EXPECT_TRUE(SameSamples(ReadAll(reader), all_));
  EXPECT_THAT(reader.Verify(), IsEmpty());
}

TEST_F(SessionFileTest, IsReadableToItsGroupAndNotToTheWorld) {
  struct stat status {};
  ASSERT_EQ(stat(file_.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0640U & ~umask(umask(0)));
}

TEST_F(SessionFileTest, NeverWritesOverAnother) {
  EXPECT_THROW(SessionFile(file_, info_), StorageError);
  EXPECT_EQ(SessionReader(file_).info().labels, info_.labels);
}

TEST_F(SessionFileTest, TellsWhereAFileIsNoSession) {
  EXPECT_THROW(SessionReader(folder_ / "none.sqlite"), SessionFileError);
  const auto text = folder_ / "text.sqlite";
  std::ofstream(text) << std::string(5000, 'x');
  EXPECT_THROW(SessionReader{text}, SessionFileError);
  const auto empty = folder_ / "empty.sqlite";
  std::ofstream(empty) << "";
  EXPECT_THROW(SessionReader{empty}, SessionFileError);
}

}  // namespace
}  // namespace mwidth::record
