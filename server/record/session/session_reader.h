// Reads a session's file, whole or in part, written by any server of this format, ended or not.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "server/exchange/crossing.h"
#include "server/record/event.h"
#include "server/record/session/session_info.h"

namespace mwidth::record {

/// A file that is no session, cannot be opened, or is of a newer format. what() says which and what to do.
class SessionFileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A block that cannot be trusted.
struct DamagedBlock {
  uint64_t number = 0;
  uint64_t first_tick = 0;
  uint64_t last_tick = 0;
  std::string reason;
};

/// Never writes to the file (but what SQLite needs beside it to read a file that its server still writes).
/// Damaged blocks are passed over, and told. One thread at a time.
class SessionReader {
 public:
  /// Throws SessionFileError.
  explicit SessionReader(const std::filesystem::path& file);
  SessionReader(SessionReader&&) noexcept;
  SessionReader& operator=(SessionReader&&) noexcept;
  ~SessionReader();

  const SessionInfo& info() const;
  /// In the order of their numbers, ticks and times. Gaps include those that damaged blocks leave.
  std::vector<Event> Events() const;
  std::vector<Marker> Markers() const;
  std::vector<Gap> Gaps() const;
  /// Those that the server noted, without a look at the blocks: what damage leaves is not among them.
  std::vector<Gap> NotedGaps() const;
  std::vector<WallClockStep> WallClockSteps() const;

  /// Replaces `samples` by the next block's, in the order of ticks; each is what the loop posted, to the bit,
  /// derived columns included. False at the end; then `samples` is empty.
  bool Next(std::vector<exchange::Sample>& samples);
  /// The next Next begins with the first block that has a tick of `tick` or above.
  void Seek(uint64_t tick);
  /// Those that Next has passed over so far.
  const std::vector<DamagedBlock>& damaged() const;

  /// Everything: the database's own check, every block's checksums, columns computed again, ticks in order.
  /// Empty: sound.
  std::vector<DamagedBlock> Verify();

 private:
  class File;
  std::unique_ptr<File> file_;
};

}  // namespace mwidth::record
