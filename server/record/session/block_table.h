// One table of blocks in a session's database.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>

#include "server/exchange/crossing.h"
#include "server/record/session/sample_codec.h"

namespace mwidth::record {

/// The rows of one table of blocks. Rows that cannot be read are told, not thrown. Asks for rows by their
/// numbers, which follow each other, so that a page of the database that is damaged hides no row of another;
/// for no more of them than the file has room for. One thread.
class BlockTable {
 public:
  struct Row {
    uint64_t number = 0;
    uint64_t first_tick = 0;
    uint64_t last_tick = 0;
    uint64_t samples = 0;
    /// Empty: sound.
    std::string damage;
  };

  /// `name` is blocks or tail; `database` outlives it.
  BlockTable(SQLite::Database& database, const std::string& name);

  /// The first row behind `number` with a tick of `tick` or above, and its samples where it is sound; none at
  /// the end.
  std::optional<Row> Next(uint64_t number, uint64_t tick, SampleDecoder& decoder,
                          std::vector<exchange::Sample>& samples);

 private:
  enum class Finding : uint8_t { kAbsent, kBefore, kThere, kUnreadable };
  struct Range {
    uint64_t first = 1;
    uint64_t last = 0;
    // False: the table's end cannot be read, and `last` is as many as fit.
    bool last_known = false;
    // The last row of all where that is no number that fits; else 0.
    uint64_t stray = 0;
  };

  uint64_t RowsThatFit() const;
  Range Numbers();
  // Whether the row has a tick of `tick` or above.
  Finding Probe(uint64_t number, uint64_t tick);
  bool IsSeenBehind(uint64_t number, uint64_t last);
  Row Read(uint64_t number, SampleDecoder& decoder, std::vector<exchange::Sample>& samples);

  const SQLite::Database& database_;
  SQLite::Statement first_;
  SQLite::Statement last_;
  SQLite::Statement probe_;
  SQLite::Statement read_;
  // The largest number that was seen to be there, and the first from which on none can be read.
  uint64_t seen_ = 0;
  uint64_t unreadable_from_ = std::numeric_limits<uint64_t>::max();
};

}  // namespace mwidth::record
