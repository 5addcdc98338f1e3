#include "server/record/session/stored_blocks.h"

#include <algorithm>
#include <set>
#include <span>
#include <utility>

#include <sqlite3.h>

namespace mwidth::record {
namespace {

// One state of the database while it lives, within another such or not.
class ReadTransaction {
 public:
  explicit ReadTransaction(SQLite::Database& database)
      : database_(database), begun_(sqlite3_get_autocommit(database.getHandle()) != 0) {
    if (begun_) {
      database_.tryExec("BEGIN");
    }
  }
  ReadTransaction(const ReadTransaction&) = delete;
  ReadTransaction& operator=(const ReadTransaction&) = delete;
  ~ReadTransaction() {
    if (begun_) {
      database_.tryExec("COMMIT");
    }
  }

 private:
  SQLite::Database& database_;
  bool begun_;
};

uint64_t Unsigned(const SQLite::Column& column) { return static_cast<uint64_t>(column.getInt64()); }

DamagedBlock DamageOf(const BlockTable::Row& row, bool tail) {
  return {.number = tail ? 0 : row.number,
          .first_tick = row.first_tick,
          .last_tick = row.last_tick,
          .reason = tail ? "row " + std::to_string(row.number) + " of the tail: " + row.damage : row.damage};
}

// Goes through the samples of a session and tells what is wrong with their order.
class OrderCheck {
 public:
  explicit OrderCheck(const std::vector<Gap>& gaps) {
    for (const Gap& gap : gaps) {
      gaps_.emplace(gap.after_tick, gap.before_tick);
    }
  }

  // What is wrong with the row, if anything.
  std::string Check(const BlockTable::Row& row, bool tail, const std::vector<exchange::Sample>& samples) {
    std::string wrong = tail ? "" : CheckNumber(row.number);
    if (!row.damage.empty()) {
      after_damage_ = true;
      return row.damage + wrong;
    }
    for (const exchange::Sample& sample : samples) {
      wrong += wrong.empty() ? CheckTick(sample.tick) : "";
      last_tick_ = sample.tick;
      after_damage_ = false;
    }
    return wrong;
  }

 private:
  std::string CheckNumber(uint64_t number) {
    const uint64_t expected = std::exchange(number_, number) + 1;
    after_damage_ = after_damage_ || number != expected;
    return number == expected ? "" : "block " + std::to_string(expected) + " is missing before it";
  }
  std::string CheckTick(uint64_t tick) const {
    if (last_tick_ == 0 || tick == last_tick_ + 1) {
      return {};
    }
    if (tick <= last_tick_) {
      return "tick " + std::to_string(tick) + " stands behind tick " + std::to_string(last_tick_);
    }
    if (after_damage_ || gaps_.contains({last_tick_, tick})) {
      return {};
    }
    return "no gap is noted before tick " + std::to_string(tick) + ", behind tick " +
           std::to_string(last_tick_);
  }

  std::set<std::pair<uint64_t, uint64_t>> gaps_;
  uint64_t number_ = 0;
  uint64_t last_tick_ = 0;
  bool after_damage_ = false;
};

}  // namespace

BlockTable::BlockTable(SQLite::Database& database, const std::string& name)
    : next_(database,
            "SELECT number FROM " + name + " WHERE number > ? AND last_tick >= ? ORDER BY number LIMIT 1"),
      last_(database, "SELECT max(number) FROM " + name),
      read_(database,
            "SELECT first_tick, last_tick, samples, checksum, data FROM " + name + " WHERE number = ?") {}

std::optional<uint64_t> BlockTable::NumberBehind(uint64_t number, uint64_t tick) {
  next_.tryReset();
  next_.bind(1, static_cast<int64_t>(number));
  next_.bind(2, static_cast<int64_t>(tick));
  const int result = next_.tryExecuteStep();
  if (result == SQLITE_ROW || result == SQLITE_DONE) {
    const auto found = result == SQLITE_ROW ? std::optional(Unsigned(next_.getColumn(0))) : std::nullopt;
    next_.tryReset();
    return found;
  }
  // A page between here and there is damaged: the rows behind it can still be asked for by their numbers.
  next_.tryReset();
  last_.tryReset();
  const bool known = last_.tryExecuteStep() == SQLITE_ROW;
  const uint64_t last = known ? Unsigned(last_.getColumn(0)) : 0;
  last_.tryReset();
  return number < last ? std::optional(number + 1) : std::nullopt;
}

BlockTable::Row BlockTable::Read(uint64_t number, SampleDecoder& decoder,
                                 std::vector<exchange::Sample>& samples) {
  Row row{.number = number, .first_tick = 0, .last_tick = 0, .samples = 0, .damage = ""};
  samples.clear();
  try {
    read_.tryReset();
    read_.bind(1, static_cast<int64_t>(number));
    if (!read_.executeStep()) {
      row.damage = "it is missing";
      return row;
    }
    row.first_tick = Unsigned(read_.getColumn(0));
    row.last_tick = Unsigned(read_.getColumn(1));
    row.samples = Unsigned(read_.getColumn(2));
    const SQLite::Column data = read_.getColumn(4);
    const auto* bytes = static_cast<const std::byte*>(data.getBlob());
    const std::span block(bytes, static_cast<std::size_t>(data.getBytes()));
    if (Checksum(block) != Unsigned(read_.getColumn(3))) {
      row.damage = "its bytes are not those that were written (checksum)";
    } else {
      decoder.Decode(block, samples);
      if (samples.front().tick != row.first_tick || samples.back().tick != row.last_tick ||
          samples.size() != row.samples) {
        row.damage = "its row tells of other samples than it has";
      }
    }
  } catch (const std::runtime_error& error) {  // SQLite::Exception or BlockError
    row.damage = error.what();
  }
  read_.tryReset();
  if (!row.damage.empty()) {
    samples.clear();
  }
  return row;
}

std::optional<BlockTable::Row> BlockTable::Next(uint64_t number, uint64_t tick, SampleDecoder& decoder,
                                                std::vector<exchange::Sample>& samples) {
  const std::optional<uint64_t> next = NumberBehind(number, tick);
  if (!next) {
    samples.clear();
    return std::nullopt;
  }
  return Read(*next, decoder, samples);
}

StoredBlocks::StoredBlocks(SQLite::Database& database, const SessionAxis& axis)
    : database_(database), decoder_(axis), blocks_(database, "blocks"), tail_(database, "tail") {}

bool StoredBlocks::Next(std::vector<exchange::Sample>& samples) {
  const ReadTransaction state(database_);
  return NextOf(blocks_, block_, false, samples) || NextOf(tail_, tail_row_, true, samples);
}

bool StoredBlocks::NextOf(BlockTable& table, uint64_t& number, bool tail,
                          std::vector<exchange::Sample>& samples) {
  const uint64_t wanted = std::max(sought_tick_, given_tick_ + 1);
  while (const auto row = table.Next(number, wanted, decoder_, samples)) {
    number = row->number;
    if (!row->damage.empty()) {
      NoteDamage(DamageOf(*row, tail));
      continue;
    }
    // Those that were given when they were in the tail.
    std::erase_if(samples, [this](const exchange::Sample& sample) { return sample.tick <= given_tick_; });
    if (!samples.empty()) {
      given_tick_ = samples.back().tick;
      return true;
    }
  }
  return false;
}

void StoredBlocks::NoteDamage(const DamagedBlock& block) {
  const bool known = std::any_of(damaged_.begin(), damaged_.end(), [&block](const DamagedBlock& other) {
    return other.number == block.number && other.first_tick == block.first_tick;
  });
  if (!known) {
    damaged_.push_back(block);
  }
}

void StoredBlocks::Seek(uint64_t tick) {
  block_ = 0;
  tail_row_ = 0;
  given_tick_ = 0;
  sought_tick_ = tick;
}

void StoredBlocks::ForEach(const Visit& visit) {
  const ReadTransaction state(database_);
  std::vector<exchange::Sample> samples;
  for (const bool tail : {false, true}) {
    BlockTable& table = tail ? tail_ : blocks_;
    uint64_t number = 0;
    while (const auto row = table.Next(number, 0, decoder_, samples)) {
      number = row->number;
      visit(*row, tail, samples);
    }
  }
}

std::vector<Gap> StoredBlocks::GapsOfDamage() {
  std::vector<Gap> gaps;
  uint64_t last_tick = 0;
  // The newest gap ends with the next sound block.
  bool open = false;
  ForEach([&](const BlockTable::Row& row, bool tail, const std::vector<exchange::Sample>&) {
    if (row.damage.empty()) {
      if (open) {
        gaps.back().before_tick = row.first_tick;
      }
      open = false;
      last_tick = row.last_tick;
      return;
    }
    if (!open) {
      gaps.push_back(
          {.after_tick = last_tick, .before_tick = 0, .missed_ticks = 0, .lost_ticks = 0, .reason = ""});
      open = true;
    }
    gaps.back().lost_ticks += row.samples;
    gaps.back().reason += (gaps.back().reason.empty() ? "" : "; ") +
                          std::string(tail ? "tail row " : "block ") + std::to_string(row.number) +
                          " is damaged: " + row.damage;
  });
  return gaps;
}

std::vector<DamagedBlock> StoredBlocks::Verify(const std::vector<Gap>& gaps) {
  std::vector<DamagedBlock> problems;
  OrderCheck order(gaps);
  ForEach([&](BlockTable::Row row, bool tail, const std::vector<exchange::Sample>& samples) {
    row.damage = order.Check(row, tail, samples);
    if (!row.damage.empty()) {
      problems.push_back(DamageOf(row, tail));
    }
  });
  return problems;
}

}  // namespace mwidth::record
