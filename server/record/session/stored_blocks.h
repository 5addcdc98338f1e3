// The blocks of samples in a session's database, in the order of their ticks.
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <SQLiteCpp/Database.h>

#include "server/record/session/block_table.h"
#include "server/record/session/sample_codec.h"
#include "server/record/session/session_reader.h"

namespace mwidth::record {

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
