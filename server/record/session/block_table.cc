#include "server/record/session/block_table.h"

#include <algorithm>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <system_error>

#include <sqlite3.h>

#include "server/record/session/block_layout.h"

namespace mwidth::record {
namespace {

uint64_t Unsigned(const SQLite::Column& column) { return static_cast<uint64_t>(column.getInt64()); }

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

}  // namespace mwidth::record
