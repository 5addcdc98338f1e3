// The blocks of samples in a session's database, in the order of their ticks.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>

#include "server/record/session/sample_codec.h"
#include "server/record/session/session_reader.h"

namespace mwidth::record {

/// The rows of one table of blocks. Rows that cannot be read are told, not thrown. One thread.
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
  std::optional<uint64_t> NumberBehind(uint64_t number, uint64_t tick);
  Row Read(uint64_t number, SampleDecoder& decoder, std::vector<exchange::Sample>& samples);

  SQLite::Statement next_;
  SQLite::Statement last_;
  SQLite::Statement read_;
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
};

}  // namespace mwidth::record
