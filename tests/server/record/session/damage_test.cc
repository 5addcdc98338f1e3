// Files that are not what was written: what is damaged is told, the rest reads, and nothing wrong is taken
// for right.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>

#include "server/record/session/session_file.h"
#include "server/record/session/session_reader.h"
#include "tests/server/record/session/recording.h"

namespace mwidth::record {
namespace {

using exchange::Sample;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class DamageTest : public testing::Test {
 protected:
  void SetUp() override {
    SwingingArm arm;
    SessionFile session(file_, InfoOf(arm.axis()));
    for (int i = 0; i < 400; ++i) {
      const std::vector<Sample> samples = arm.Take(50);
      for (const Sample& sample : samples) {
        written_[sample.tick] = sample;
      }
      session.Append(samples, "lost");
    }
    session.End(SessionState::kEnded, 0);
    std::ifstream in(file_, std::ios::binary);
    bytes_.assign(std::istreambuf_iterator<char>(in), {});
  }
  void Execute(const std::string& statement) {
    SQLite::Database(file_.string(), SQLite::OPEN_READWRITE).exec(statement);
  }
  // Flips one bit of what the database has of a block.
  void FlipInBlock(int number, std::mt19937_64& random) {
    SQLite::Database database(file_.string(), SQLite::OPEN_READWRITE);
    SQLite::Statement select(database, "SELECT data FROM blocks WHERE number = " + std::to_string(number));
    select.executeStep();
    std::string data = select.getColumn(0).getString();
    const uint64_t bit = random() % (data.size() * 8);
    data[bit / 8] = static_cast<char>(data[bit / 8] ^ (1 << bit % 8));
    select.reset();
    SQLite::Statement update(database, "UPDATE blocks SET data = ? WHERE number = " + std::to_string(number));
    update.bind(1, data.data(), static_cast<int>(data.size()));
    update.exec();
  }
  // Reads everything; each sample must be one that was written.
  std::size_t ReadSound(SessionReader& reader) {
    std::size_t count = 0;
    std::vector<Sample> block;
    while (reader.Next(block)) {
      for (const Sample& sample : block) {
        EXPECT_TRUE(written_.contains(sample.tick) && SameSample(written_[sample.tick], sample));
        ++count;
      }
    }
    return count;
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "session.sqlite";
  std::map<uint64_t, Sample> written_;
  std::string bytes_;
};

TEST_F(DamageTest, NamesTheBlockWithAFlippedBitAndReadsTheRest) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 40; ++i) {
    std::ofstream(file_, std::ios::binary) << bytes_;
    FlipInBlock(3, random);
    SessionReader reader(file_);
    EXPECT_EQ(ReadSound(reader), 20000 - 4096);
    ASSERT_THAT(reader.damaged(), SizeIs(1));
    EXPECT_EQ(reader.damaged()[0].number, 3);
    EXPECT_THAT(reader.damaged()[0].reason, HasSubstr("checksum"));
    const std::vector<DamagedBlock> verified = reader.Verify();
    ASSERT_THAT(verified, SizeIs(1));
    EXPECT_EQ(verified[0].number, 3);
    std::vector<Gap> gaps = reader.Gaps();
    std::erase_if(gaps, [](const Gap& gap) { return gap.lost_ticks == 0; });
    ASSERT_THAT(gaps, SizeIs(1));
    EXPECT_EQ(gaps[0].lost_ticks, 4096);
    EXPECT_LT(gaps[0].after_tick, verified[0].first_tick);
    EXPECT_GT(gaps[0].before_tick, verified[0].last_tick);
  }
}

TEST_F(DamageTest, TellsABlockThatIsMissing) {
  Execute("DELETE FROM blocks WHERE number = 2");
  SessionReader reader(file_);
  EXPECT_EQ(ReadSound(reader), 20000 - 4096);
  const std::vector<DamagedBlock> verified = reader.Verify();
  ASSERT_THAT(verified, SizeIs(1));
  EXPECT_THAT(verified[0].reason, HasSubstr("block 2 is missing"));
}

TEST_F(DamageTest, TellsBlocksThatChangedPlacesOrTellOfOtherTicks) {
  Execute("UPDATE blocks SET number = -1 WHERE number = 2");
  Execute("UPDATE blocks SET number = 2 WHERE number = 3");
  Execute("UPDATE blocks SET number = 3 WHERE number = -1");
  EXPECT_FALSE(SessionReader(file_).Verify().empty());
  std::ofstream(file_, std::ios::binary) << bytes_;
  Execute("UPDATE blocks SET last_tick = last_tick + 1 WHERE number = 2");
  EXPECT_THAT(SessionReader(file_).Verify(), SizeIs(1));
}

TEST_F(DamageTest, TellsAGapThatNobodyNoted) {
  Execute("DELETE FROM gaps WHERE id = 7");
  const std::vector<DamagedBlock> verified = SessionReader(file_).Verify();
  ASSERT_THAT(verified, SizeIs(1));
  EXPECT_THAT(verified[0].reason, HasSubstr("no gap is noted"));
}

// Any byte of the file, also of the database's own structure.
TEST_F(DamageTest, TakesNothingWrongForRightWhereverBytesAreDamaged) {
  std::mt19937_64 random(2);
  int told = 0;
  for (int i = 0; i < 300; ++i) {
    std::string damaged = bytes_;
    const int flips = 1 + static_cast<int>(random() % 3);
    for (int k = 0; k < flips; ++k) {
      const uint64_t bit = random() % (damaged.size() * 8);
      damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << bit % 8));
    }
    std::ofstream(file_, std::ios::binary) << damaged;
    try {
      SessionReader reader(file_);
      ReadSound(reader);
      reader.Gaps();
      told += reader.Verify().empty() ? 0 : 1;
    } catch (const SessionFileError&) {
      ++told;
    }
  }
  EXPECT_GT(told, 200);
}

TEST_F(DamageTest, ReadsWhatALongerTruncationLeaves) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 50; ++i) {
    std::ofstream(file_, std::ios::binary) << bytes_.substr(0, random() % bytes_.size());
    try {
      SessionReader reader(file_);
      ReadSound(reader);
      EXPECT_FALSE(reader.Verify().empty());
    } catch (const SessionFileError&) {
      continue;
    }
  }
}

}  // namespace
}  // namespace mwidth::record
