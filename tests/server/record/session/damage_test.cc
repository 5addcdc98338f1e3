// Files that are not what was written: what is damaged is told, the rest reads, and nothing wrong is taken
// for right.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
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
#include "server/record/session/session_store.h"
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
  // The pages of the database that have the table of blocks; `kind` is a pattern.
  std::vector<int> PagesOfBlocks(const std::string& kind) {
    SQLite::Database database(file_.string());
    SQLite::Statement select(
        database, "SELECT pageno FROM dbstat WHERE name = 'blocks' AND pagetype LIKE '" + kind + "'");
    std::vector<int> pages;
    while (select.executeStep()) {
      pages.push_back(select.getColumn(0).getInt());
    }
    return pages;
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

// One with many small blocks: a page of the table has several, and the table many pages.
class PageDamageTest : public DamageTest {
 protected:
  static constexpr int kPageBytes = 4096;

  void SetUp() override {
    SwingingArm arm;
    SessionFile session(file_, InfoOf(arm.axis()));
    for (int i = 0; i < 150; ++i) {
      const std::vector<Sample> samples = arm.Take(60);
      arm.Take(1);  // lost, so that a block ends here
      for (const Sample& sample : samples) {
        written_[sample.tick] = sample;
      }
      session.Append(samples, "lost");
      session.Commit(Durability::kProcess);
    }
    session.End(SessionState::kEnded, 0);
    std::ifstream in(file_, std::ios::binary);
    bytes_.assign(std::istreambuf_iterator<char>(in), {});
    for (const int page : PagesOfBlocks("leaf")) {
      leaves_[page] = NumbersOn(page);
    }
    SessionReader reader(file_);
    std::vector<Sample> block;
    for (int number = 1; reader.Next(block); ++number) {
      sizes_.push_back(block.size());
    }
  }
  // The numbers of the rows of a leaf of the table.
  std::vector<uint64_t> NumbersOn(int page) const {
    const auto byte = [&](std::size_t at) {
      return static_cast<uint8_t>(bytes_[static_cast<std::size_t>(page - 1) * kPageBytes + at]);
    };
    const auto varint = [&](std::size_t& at) {
      uint64_t value = 0;
      do {
        value = value << 7 | (byte(at) & 0x7FU);
      } while (byte(at++) & 0x80U);
      return value;
    };
    std::vector<uint64_t> numbers;
    for (std::size_t cell = 0; cell < byte(3) * 256U + byte(4); ++cell) {
      std::size_t at = byte(8 + 2 * cell) * 256U + byte(9 + 2 * cell);
      varint(at);  // bytes of the row
      numbers.push_back(varint(at));
    }
    return numbers;
  }
  std::size_t SamplesOf(const std::vector<uint64_t>& numbers) const {
    std::size_t samples = 0;
    for (const uint64_t number : numbers) {
      samples += sizes_.at(number - 1);
    }
    return samples;
  }
  void Write(const std::string& bytes) { std::ofstream(file_, std::ios::binary) << bytes; }

  std::map<int, std::vector<uint64_t>> leaves_;
  std::vector<std::size_t> sizes_;
};

TEST_F(PageDamageTest, LosesTheBlocksOfAPageThatCannotBeReadNamesThemAndReadsAllOthers) {
  ASSERT_GT(leaves_.size(), 10);
  for (const auto& [page, numbers] : leaves_) {
    std::string damaged = bytes_;
    damaged[static_cast<std::size_t>(page - 1) * kPageBytes] = 0;  // no kind of page
    Write(damaged);
    SessionReader reader(file_);
    const std::size_t sound = written_.size() - SamplesOf(numbers);
    EXPECT_EQ(reader.info().sample_count, sound);
    EXPECT_EQ(ReadSound(reader), sound) << "page " << page;
    const bool last = numbers.back() == sizes_.size();
    std::vector<uint64_t> named;
    for (const DamagedBlock& block : reader.damaged()) {
      named.push_back(block.number);
    }
    // Where the last page cannot be read nobody knows how many it had.
    EXPECT_EQ(named, last ? std::vector{numbers.front()} : numbers) << "page " << page;
    if (last) {
      EXPECT_THAT(reader.damaged()[0].reason, HasSubstr("nobody knows"));
    }
    const std::vector<Gap> gaps = reader.Gaps();
    EXPECT_TRUE(std::any_of(gaps.begin(), gaps.end(), [&numbers](const Gap& gap) {
      return gap.reason.find("block " + std::to_string(numbers.front()) + " is damaged") != std::string::npos;
    }));
    EXPECT_FALSE(reader.Verify().empty());
  }
}

TEST_F(PageDamageTest, ReadsEveryBlockOfTheOtherPagesWhateverBitsOfOneAreFlipped) {
  std::mt19937_64 random(4);
  for (const auto& [page, numbers] : leaves_) {
    for (int i = 0; i < 10; ++i) {
      std::string damaged = bytes_;
      // The page's head, or its first bytes of cells: there rows have their numbers.
      const std::size_t at = i < 5 ? random() % 24 : random() % kPageBytes;
      char& byte = damaged[static_cast<std::size_t>(page - 1) * kPageBytes + at];
      byte = static_cast<char>(byte ^ (1 << random() % 8));
      Write(damaged);
      SessionReader reader(file_);
      EXPECT_GE(ReadSound(reader), written_.size() - SamplesOf(numbers))
          << "page " << page << ", byte " << at;
    }
  }
}

TEST_F(PageDamageTest, EndsWhereARowHasANumberOutOfThisWorld) {
  Execute("UPDATE blocks SET number = " + std::to_string(int64_t{1} << 62) + " WHERE number = 150");
  SessionReader reader(file_);
  EXPECT_EQ(ReadSound(reader), written_.size());
  EXPECT_THAT(reader.Verify(), SizeIs(1));
}

TEST_F(PageDamageTest, IsRecoveredToTheLastSampleThatReads) {
  Execute("PRAGMA journal_mode = WAL");
  Execute("UPDATE info SET value = 0 WHERE key = 'state'");
  Execute("DELETE FROM info WHERE key = 'end_wall_ns'");
  Execute("UPDATE blocks SET data = zeroblob(100) WHERE number = 150");
  ASSERT_TRUE(SessionStore::Recover(file_));
  const SessionInfo info = SessionReader(file_).info();
  uint64_t last = 0;
  for (int i = 0; i < 149; ++i) {
    last += sizes_[static_cast<std::size_t>(i)];
  }
  const Sample& sample = std::next(written_.begin(), static_cast<std::ptrdiff_t>(last) - 1)->second;
  EXPECT_EQ(info.end_wall_ns, sample.monotonic_ns - info.start_monotonic_ns + info.start_wall_ns);
}

// Any byte of the file, also of the database's own structure.
TEST_F(DamageTest, TakesNothingWrongForRightWhereverBytesAreDamaged) {
  const std::vector<int> pages = PagesOfBlocks("%");
  std::mt19937_64 random(2);
  int told = 0;
  for (int i = 0; i < 300; ++i) {
    std::string damaged = bytes_;
    const int flips = 1 + static_cast<int>(random() % 3);
    bool only_blocks = true;
    for (int k = 0; k < flips; ++k) {
      const uint64_t bit = random() % (damaged.size() * 8);
      const int page = static_cast<int>(bit / 8 / 4096) + 1;
      only_blocks = only_blocks && std::count(pages.begin(), pages.end(), page) > 0;
      damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << bit % 8));
    }
    std::ofstream(file_, std::ios::binary) << damaged;
    try {
      SessionReader reader(file_);
      ReadSound(reader);
      reader.Gaps();
      told += reader.Verify().empty() ? 0 : 1;
    } catch (const SessionFileError& error) {
      EXPECT_FALSE(only_blocks) << "the file was lost with a block: " << error.what();
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
