#include "server/record/session/stored_blocks.h"

#include <algorithm>
#include <filesystem>
#include <span>
#include <system_error>

#include <sqlite3.h>

#include "server/record/session/block_layout.h"

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
    : database_(database),
      first_(database, "SELECT min(number) FROM " + name),
      last_(database, "SELECT max(number) FROM " + name),
      probe_(database, "SELECT last_tick FROM " + name + " WHERE number = ?"),
      read_(database,
            "SELECT first_tick, last_tick, samples, checksum, data FROM " + name + " WHERE number = ?") {}

uint64_t BlockTable::RowsThatFit() const {
  const char* file = sqlite3_db_filename(database_.getHandle(), "main");
  uint64_t bytes = 0;
  for (const char* suffix : {"", "-wal"}) {
    std::error_code none;
    const auto size = std::filesystem::file_size(file + std::string(suffix), none);
    bytes += none ? 0 : size;
  }
  return bytes / kHeadBytes + 1;
}

BlockTable::Range BlockTable::Numbers() {
  const auto ask = [](SQLite::Statement& statement) {
    statement.tryReset();
    const bool read = statement.tryExecuteStep() == SQLITE_ROW;
    const auto number = read ? std::optional(Unsigned(statement.getColumn(0))) : std::nullopt;
    statement.tryReset();
    return number;
  };
  const uint64_t fit = RowsThatFit();
  const std::optional<uint64_t> first = ask(first_);
  const std::optional<uint64_t> last = ask(last_);
  if (first && last && *first <= *last && *last - *first < fit) {
    return {.first = *first, .last = *last, .last_known = true};
  }
  if (first && (!last || *first <= *last)) {
    return {.first = *first, .last = *first + fit - 1, .last_known = false, .stray = last.value_or(0)};
  }
  if (!last || *last <= fit) {
    return {.first = 1, .last = last.value_or(fit), .last_known = last.has_value()};
  }
  // The numbers of a tail go on from one to the next: the row before the first that can be read is told, and
  // stands for those before it.
  uint64_t begin = *last - std::min<uint64_t>(fit, kMaxBlockSamples);
  while (begin < *last && Probe(begin + 1, 0) != Finding::kThere) {
    ++begin;
  }
  return {.first = begin, .last = *last, .last_known = true};
}

BlockTable::Finding BlockTable::Probe(uint64_t number, uint64_t tick) {
  probe_.tryReset();
  probe_.bind(1, static_cast<int64_t>(number));
  const int result = probe_.tryExecuteStep();
  Finding finding = Finding::kUnreadable;
  if (result == SQLITE_DONE) {
    finding = Finding::kAbsent;
  } else if (result == SQLITE_ROW) {
    seen_ = std::max(seen_, number);
    finding = Unsigned(probe_.getColumn(0)) < tick ? Finding::kBefore : Finding::kThere;
  }
  probe_.tryReset();
  return finding;
}

bool BlockTable::IsSeenBehind(uint64_t number, uint64_t last) {
  for (uint64_t behind = number + 1; seen_ <= number && behind <= last; ++behind) {
    Probe(behind, 0);
  }
  return seen_ > number;
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
  samples.clear();
  if (number >= unreadable_from_) {
    return std::nullopt;
  }
  const Range range = Numbers();
  for (uint64_t next = std::max(number + 1, range.first); next <= range.last; ++next) {
    const Finding finding = Probe(next, tick);
    if (finding == Finding::kAbsent || finding == Finding::kBefore) {
      continue;
    }
    Row row = Read(next, decoder, samples);
    if (finding == Finding::kUnreadable && !range.last_known && !IsSeenBehind(next, range.last)) {
      unreadable_from_ = next;
      row.damage += "; nor can any behind it, and nobody knows how many these are";
    }
    return row;
  }
  if (range.stray > number) {
    Row row = Read(range.stray, decoder, samples);
    if (!row.damage.empty() || row.last_tick >= tick) {
      return row;
    }
    samples.clear();
  }
  return std::nullopt;
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
