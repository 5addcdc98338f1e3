// The blocks of samples in a session's database, in the order of their ticks.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>

#include "server/record/session/sample_codec.h"
#include "server/record/session/session_reader.h"

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

/// First the table blocks, then the tail. Each call sees one state of a database that may grow meanwhile, and
/// that has in blocks later what was in the tail. One thread.
class StoredBlocks {
 public:
  /// `database` outlives it.
  StoredBlocks(SQLite::Database& database, const SessionAxis& axis);

  /// As SessionReader.
  bool Next(std::vector<exchange::Sample>& samples);
  void Seek(uint64_t tick);
  const std::vector<DamagedBlock>& damaged() const { return damaged_; }

  /// What is missing because a block cannot be trusted, whether Next has come to it or not.
  std::vector<Gap> GapsOfDamage();

  /// All blocks and the tail: what is damaged, missing, out of order, or absent without one of `gaps` that
  /// says so.
  std::vector<DamagedBlock> Verify(const std::vector<Gap>& gaps);

  /// Counts, for `info`, the samples that can be read.
  void Count(SessionInfo& info);

 private:
  using Visit = std::function<void(const BlockTable::Row&, bool tail, const std::vector<exchange::Sample>&)>;

  void ForEach(const Visit& visit);
  bool NextOf(BlockTable& table, uint64_t& number, bool tail, std::vector<exchange::Sample>& samples);
  void NoteDamage(const DamagedBlock& block);

  SQLite::Database& database_;
  SampleDecoder decoder_;
  BlockTable blocks_;
  BlockTable tail_;
  // The last rows that were read, the last tick that was given, and the tick to find first.
  uint64_t block_ = 0;
  uint64_t tail_row_ = 0;
  uint64_t given_tick_ = 0;
  uint64_t sought_tick_ = 0;
  std::vector<DamagedBlock> damaged_;
  // Their numbers and first ticks.
  std::set<std::pair<uint64_t, uint64_t>> told_;
};

}  // namespace mwidth::record
