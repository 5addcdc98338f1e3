#include "server/record/session/stored_blocks.h"

#include <algorithm>

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
  if (told_.emplace(block.number, block.first_tick).second) {
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

void StoredBlocks::Count(SessionInfo& info) {
  info.sample_count = info.first_tick = info.last_tick = 0;
  ForEach([&info](const BlockTable::Row& row, bool, const std::vector<exchange::Sample>& samples) {
    if (!samples.empty()) {
      info.first_tick = info.sample_count == 0 ? row.first_tick : info.first_tick;
      info.last_tick = row.last_tick;
      info.sample_count += samples.size();
    }
  });
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
