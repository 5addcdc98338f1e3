// The rows of a session's file, as statements that are prepared once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>

#include "server/exchange/crossing.h"
#include "server/record/event.h"
#include "server/record/session/session_info.h"

namespace mwidth::record {

/// One thread. Throws SQLite::Exception.
class SessionRows {
 public:
  /// The tables exist; `database` outlives it.
  explicit SessionRows(SQLite::Database& database);

  void Begin() { Execute(begin_); }
  void Commit() { Execute(commit_); }

  /// `bytes` are those of `samples`, encoded.
  void InsertBlock(int64_t number, std::span<const exchange::Sample> samples,
                   std::span<const std::byte> bytes) {
    Insert(block_, number, samples, bytes);
  }
  void InsertTail(int64_t number, std::span<const exchange::Sample> samples,
                  std::span<const std::byte> bytes) {
    Insert(tail_, number, samples, bytes);
  }
  void ClearTail() { Execute(clear_tail_); }
  void Insert(const Event& event);
  void Insert(const Marker& marker);
  void Insert(const Gap& gap);
  void Insert(const WallClockStep& step);

 private:
  static void Execute(SQLite::Statement& statement);
  static void Insert(SQLite::Statement& insert, int64_t number, std::span<const exchange::Sample> samples,
                     std::span<const std::byte> bytes);

  SQLite::Statement begin_;
  SQLite::Statement commit_;
  SQLite::Statement block_;
  SQLite::Statement tail_;
  SQLite::Statement clear_tail_;
  SQLite::Statement event_;
  SQLite::Statement marker_;
  SQLite::Statement gap_;
  SQLite::Statement step_;
};

}  // namespace mwidth::record
