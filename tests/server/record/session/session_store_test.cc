#include "server/record/session/session_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include <SQLiteCpp/Database.h>

#include "server/record/session/session_reader.h"
#include "tests/server/record/session/recording.h"

namespace mwidth::record {
namespace {

namespace fs = std::filesystem;
using exchange::Sample;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class SessionStoreTest : public testing::Test {
 protected:
  SessionRefusal RefusalOf(const SessionInfo& info) {
    try {
      store_.Create(info);
    } catch (const SessionRefused& refused) {
      return refused.reason();
    }
    ADD_FAILURE() << "was not refused";
    return {};
  }

  TemporaryFolder folder_;
  SwingingArm arm_;
  SessionInfo info_ = InfoOf(arm_.axis());
  SessionStore store_{folder_ / "sessions", 0};
};

TEST_F(SessionStoreTest, NamesASessionAfterItsLabelsAndItsStart) {
  EXPECT_EQ(SessionId(info_.labels, 1'795'329'120'999'999'999),
            "sub-01_ses-1_task-reach_run-02_20261122T063200Z");
  info_.labels.visit = "";
  info_.labels.run = 123;
  EXPECT_EQ(SessionId(info_.labels, 1'795'329'120'000'000'000), "sub-01_task-reach_run-123_20261122T063200Z");
}

TEST_F(SessionStoreTest, MakesItsFolderWithTheFirstSession) {
  EXPECT_THAT(store_.List(), IsEmpty());
  EXPECT_FALSE(std::filesystem::exists(store_.folder()));
  const NewSession session = store_.Create(info_);
  EXPECT_EQ(session.info.id, SessionId(info_.labels, info_.start_wall_ns));
  EXPECT_EQ(session.path, store_.folder() / (session.info.id + ".sqlite"));
  EXPECT_TRUE(std::filesystem::exists(session.path));
}

TEST_F(SessionStoreTest, CountsRunsOfEachSubjectVisitAndTask) {
  info_.labels.run = 0;
  EXPECT_EQ(store_.Create(info_).info.labels.run, 1);
  EXPECT_EQ(store_.Create(info_).info.labels.run, 2);
  SessionInfo other = info_;
  other.labels.visit = "";
  EXPECT_EQ(store_.Create(other).info.labels.run, 1);
  other = info_;
  other.labels.task = "reachfar";
  EXPECT_EQ(store_.Create(other).info.labels.run, 1);
  info_.labels.run = 7;
  EXPECT_EQ(store_.Create(info_).info.labels.run, 7);
  info_.start_wall_ns += 1'000'000'000'000;
  EXPECT_EQ(RefusalOf(info_), SessionRefusal::kSessionExists) << "at another time, but the same run";
  info_.labels.run = 0;
  EXPECT_EQ(store_.Create(info_).info.labels.run, 8);
}

TEST_F(SessionStoreTest, RefusesWhereTooLittleIsFree) {
  SessionStore store(folder_ / "sessions", std::numeric_limits<uint64_t>::max());
  try {
    store.Create(info_);
    FAIL() << "was not refused";
  } catch (const SessionRefused& refused) {
    EXPECT_EQ(refused.reason(), SessionRefusal::kStorageFull);
    EXPECT_THAT(refused.what(), HasSubstr("make room"));
  }
}

TEST_F(SessionStoreTest, RefusesWhereTheFolderCannotBe) {
  std::ofstream(folder_ / "sessions") << "a file";
  EXPECT_EQ(RefusalOf(info_), SessionRefusal::kStorageFailed);
}

TEST_F(SessionStoreTest, FindsNoFileOutsideItsFolder) {
  const NewSession session = store_.Create(info_);
  EXPECT_EQ(store_.PathOf(session.info.id), session.path);
  std::ofstream(folder_ / "outside.sqlite") << "";
  for (const char* id : {"", ".", "..", "../outside", "/etc/passwd", "none", "a/b", "a\\b", "a.b"}) {
    EXPECT_EQ(store_.PathOf(id), std::nullopt) << id;
  }
  EXPECT_EQ(store_.PathOf(session.info.id + std::string("\0", 1)), std::nullopt);
}

TEST_F(SessionStoreTest, ListsTheNewestFirstAndTheUnreadable) {
  const NewSession first = store_.Create(info_);
  info_.labels.run = 0;
  info_.start_wall_ns += 5'000'000'000;
  {
    NewSession second = store_.Create(info_);
    second.file.Append(arm_.Take(10), "");
    second.file.End(SessionState::kEnded, info_.start_wall_ns);
  }
  std::ofstream(store_.folder() / "broken.sqlite") << "no database";
  std::ofstream(store_.folder() / "notes.txt") << "no session";
  const std::vector<StoredSession> sessions = store_.List();
  ASSERT_THAT(sessions, SizeIs(3));
  EXPECT_EQ(sessions[0].info->labels.run, 3);
  EXPECT_EQ(sessions[0].info->sample_count, 10);
  EXPECT_FALSE(sessions[0].recording);
  EXPECT_GT(sessions[0].file_bytes, 1000);
  EXPECT_EQ(sessions[1].id, first.info.id);
  EXPECT_TRUE(sessions[1].recording);
  EXPECT_EQ(sessions[2].id, "broken");
  EXPECT_FALSE(sessions[2].info);
  EXPECT_THAT(sessions[2].problem, HasSubstr("broken.sqlite"));
}

TEST_F(SessionStoreTest, RecoversASessionWhoseServerDied) {
  std::vector<Sample> samples;
  std::filesystem::path path;
  {
    NewSession session = store_.Create(info_);
    path = session.path;
    for (int i = 0; i < 200; ++i) {
      const std::vector<Sample> some = arm_.Take(50);
      samples.insert(samples.end(), some.begin(), some.end());
      session.file.Append(some, "lost");
      session.file.Commit(Durability::kProcess);
    }
    session.file.Add(WallClockStep{.monotonic_ns = samples[5000].monotonic_ns,
                                   .offset_ns = info_.start_wall_ns - info_.start_monotonic_ns + 77});
    session.file.Commit(Durability::kProcess);
    session.file.Append(arm_.Take(50), "never committed");
    EXPECT_FALSE(SessionStore::Recover(path)) << "it is being written";
  }
  EXPECT_EQ(SessionReader(path).info().state, SessionState::kOpen);
  ASSERT_THAT(store_.RecoverAll(), SizeIs(1));
  SessionReader reader(path);
  EXPECT_EQ(reader.info().state, SessionState::kRecovered);
  EXPECT_EQ(reader.info().end_wall_ns,
            samples.back().monotonic_ns - info_.start_monotonic_ns + info_.start_wall_ns + 77);
  EXPECT_EQ(reader.info().sample_count, samples.size());
  std::vector<Sample> all;
  std::vector<Sample> block;
  std::vector<std::size_t> sizes;
  while (reader.Next(block)) {
    sizes.push_back(block.size());
    all.insert(all.end(), block.begin(), block.end());
  }
  EXPECT_TRUE(SameSamples(all, samples));
  EXPECT_THAT(sizes, ElementsAre(4096, 4096, 10000 - 2 * 4096)) << "the tail is a block";
  EXPECT_EQ(reader.Gaps().back().after_tick, samples.back().tick);
  EXPECT_EQ(reader.Gaps().back().before_tick, 0);
  EXPECT_THAT(reader.Verify(), IsEmpty());
  EXPECT_THAT(store_.RecoverAll(), IsEmpty());
  std::vector<std::string> left;
  for (const auto& entry : std::filesystem::directory_iterator(store_.folder())) {
    left.push_back(entry.path().filename());
  }
  EXPECT_THAT(left, ElementsAre(path.filename())) << "nothing else is left in the folder";
}

TEST_F(SessionStoreTest, BringsIntoAClosedFileWhatItsReadersLeftInALog) {
  fs::path path;
  SQLite::Database reader(":memory:");
  {
    NewSession session = store_.Create(info_);
    path = session.path;
    reader = SQLite::Database(path.string());
    reader.exec("BEGIN");
    reader.execAndGet("SELECT count(*) FROM blocks");  // an old state of it
    session.file.Append(arm_.Take(5000), "lost");
    session.file.End(SessionState::kEnded, info_.start_wall_ns);
  }
  EXPECT_GT(fs::file_size(path.string() + "-wal"), 0);
  reader = SQLite::Database(":memory:");
  EXPECT_THAT(store_.RecoverAll(), IsEmpty()) << "it was closed";
  EXPECT_FALSE(fs::exists(path.string() + "-wal"));
  EXPECT_EQ(SessionReader(path).info().sample_count, 5000);
  EXPECT_THAT(SessionReader(path).Verify(), IsEmpty());
}

TEST_F(SessionStoreTest, TellsFreeSpaceAsItIsConfigured) {
  SessionStore store(folder_ / "sessions", 900'000'000'000'000'000);
  try {
    store.Create(info_);
    FAIL() << "was not refused";
  } catch (const SessionRefused& refused) {
    EXPECT_THAT(refused.what(), HasSubstr("only where there are 900000000000 MB:"));
  }
}

// A lock whose file was removed between its opening and its locking would be nobody's: many take and give one
// back, and never two have it.
TEST_F(SessionStoreTest, GivesALockToOneAtATimeAlsoWhileItsFileComesAndGoes) {
  std::atomic<int> holders = 0;
  std::atomic<int> taken = 0;
  std::atomic<bool> shared = false;
  std::vector<std::jthread> takers;
  for (int i = 0; i < 4; ++i) {
    takers.emplace_back([&] {
      for (int n = 0; n < 5000; ++n) {
        if (const auto lock = SessionLock::Take(folder_ / "one")) {
          shared = shared || ++holders > 1;
          std::this_thread::yield();
          --holders;
          ++taken;
        }
      }
    });
  }
  takers.clear();
  EXPECT_FALSE(shared);
  EXPECT_GT(taken, 0);
}

TEST_F(SessionStoreTest, RecoversASessionWithoutASample) {
  const auto path = store_.Create(info_).path;
  EXPECT_TRUE(SessionStore::Recover(path));
  EXPECT_EQ(SessionReader(path).info().end_wall_ns, info_.start_wall_ns);
}

TEST_F(SessionStoreTest, TellsWhatCannotBeRecovered) {
  store_.Create(info_);
  std::ofstream(store_.folder() / "broken.sqlite") << "no database";
  const std::vector<StoredSession> recovered = store_.RecoverAll();
  ASSERT_THAT(recovered, SizeIs(2));
  for (const StoredSession& session : recovered) {
    EXPECT_EQ(session.problem.empty(), session.id != "broken") << session.problem;
  }
}

}  // namespace
}  // namespace mwidth::record
