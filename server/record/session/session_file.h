// Writes one session's file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "server/exchange/crossing.h"
#include "server/record/event.h"
#include "server/record/session/session_info.h"

namespace mwidth::record {

/// The disk, or what stands for it, did not take it. what() has the file, and the reason as SQLite or the
/// system tells it.
class StorageError : public std::runtime_error {
 public:
  StorageError(const std::string& what, bool disk_full) : std::runtime_error(what), disk_full_(disk_full) {}

  bool disk_full() const noexcept { return disk_full_; }

 private:
  bool disk_full_;
};

/// Brings the names in a folder to the disk, so that they are found after a loss of power. Throws
/// StorageError.
void SyncFolder(const std::filesystem::path& folder);

/// How sure a commit is.
enum class Durability : uint8_t {
  /// Survives the death of this process.
  kProcess,
  /// On the disk: survives the loss of power.
  kPower,
};

/// Holds back what it is given until Commit, which writes all of it or, when it throws, nothing, and may be
/// tried again. The newest samples go into small blocks, cheap to write often; as soon as there are
/// kBlockSamples of them, or a tick is lost behind them, they become one block of their own. One thread, but
/// for Sync.
class SessionFile {
 public:
  static constexpr std::size_t kBlockSamples = 4096;

  /// Creates `file`, readable to its group, with `info` in it, on the disk when this returns. Throws
  /// StorageError, also where the file exists, and leaves no new file then.
  SessionFile(const std::filesystem::path& file, const SessionInfo& info);
  /// Takes up a file that its server left open, to End it; Add may still say what became of it. Throws
  /// SessionFileError (session_reader.h) where it is no session, StorageError where it cannot be written.
  static SessionFile Reopen(const std::filesystem::path& file);
  SessionFile(SessionFile&&) noexcept;
  SessionFile& operator=(SessionFile&&) noexcept;
  /// What was not committed is lost; the session stays open.
  ~SessionFile();

  /// Samples in the order of ticks; those not above the last one are passed over. Notes a gap wherever ticks
  /// are absent; `lost_reason` is why those that ran are.
  void Append(std::span<const exchange::Sample> samples, std::string_view lost_reason);
  void Add(const Event& event);
  void Add(const Marker& marker);
  void Add(const Gap& gap);
  void Add(const WallClockStep& step);

  /// True where there is something to commit.
  bool HasPending() const;
  /// How many samples wait for Commit.
  std::size_t pending_samples() const;
  /// Waits for no disk, unless `durability` is kPower: then it is followed by a Sync. Throws StorageError.
  void Commit(Durability durability);

  /// Waits until what was committed before is on the disk. Any thread, also while another commits; in a
  /// server a thread of its own, so that a disk that is slow holds up no commit. Throws StorageError.
  void Sync();

  /// Commits all to the disk, `state`, `end_wall_ns` and what was lost behind the last sample with it. The
  /// file is whole by itself then, but where somebody reads an older state of it for seconds; it is a single
  /// one, but where somebody has it open; Settle makes up for both. Afterwards only destroy it. Throws
  /// StorageError, and then the session goes on, or is ended again.
  void End(SessionState state, std::optional<int64_t> end_wall_ns, const std::optional<Gap>& last_gap = {});
  /// Makes a closed session that has a log beside it a single file, if nobody has it open now. Throws
  /// StorageError where it cannot be written.
  static void Settle(const std::filesystem::path& file);

 private:
  class Database;
  explicit SessionFile(std::unique_ptr<Database> database);

  std::unique_ptr<Database> database_;
};

}  // namespace mwidth::record
