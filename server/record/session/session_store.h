// The folder of a server's sessions.
#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "server/record/session/session_file.h"
#include "server/record/session/session_info.h"
#include "server/record/session/session_lock.h"

namespace mwidth::record {

enum class SessionRefusal : uint8_t {
  /// The axis is being recorded.
  kSessionOpen,
  /// None is.
  kNoSession,
  /// This subject did this run of the task before.
  kSessionExists,
  kStorageFull,
  kStorageFailed,
};

/// what() is for a person: what is wrong, and what to do.
class SessionRefused : public std::runtime_error {
 public:
  SessionRefused(SessionRefusal reason, const std::string& what)
      : std::runtime_error(what), reason_(reason) {}

  SessionRefusal reason() const noexcept { return reason_; }

 private:
  SessionRefusal reason_;
};

/// One file of the folder.
struct StoredSession {
  std::string id;
  std::filesystem::path file;
  /// With what SQLite keeps beside it.
  uint64_t file_bytes = 0;
  /// None where it cannot be read, and then `problem` says why.
  std::optional<SessionInfo> info;
  std::string problem;
  /// A server that lives writes it.
  bool recording = false;
};

/// A session that has just begun.
struct NewSession {
  SessionInfo info;
  std::filesystem::path path;
  // Given back after the file is closed.
  SessionLock lock;
  SessionFile file;
};

/// Any thread.
class SessionStore {
 public:
  /// The folder need not exist before the first session. A session begins only where this many bytes are
  /// free.
  SessionStore(std::filesystem::path folder, uint64_t min_free_bytes);

  const std::filesystem::path& folder() const { return folder_; }

  /// All sessions, the newest first; none where there is no folder. Throws std::filesystem::filesystem_error
  /// where it cannot be read.
  std::vector<StoredSession> List() const;
  /// What a file of the folder says of itself, or why it cannot.
  static StoredSession Examine(const std::filesystem::path& file);
  /// The file of a session of this id, if there is one; never one outside the folder, whatever `id` is.
  std::optional<std::filesystem::path> PathOf(std::string_view id) const;

  /// Creates the file of a session, with `info`, whose id and, where that is 0, run it fills in: one above
  /// the highest of this subject, visit and task. Throws SessionRefused.
  NewSession Create(SessionInfo info);

  /// Removes a session that was created in vain, once its NewSession is gone.
  static void Discard(const std::filesystem::path& file);

  /// Closes a session whose server died: what the tail has becomes a block, what is lost is noted as a gap,
  /// the state is kRecovered and the end that of the last sample. False where it was closed already (then
  /// what its readers left in a log comes into the file), or a server that lives writes it. Throws
  /// SessionFileError where it is no session, StorageError where it
  /// cannot be written.
  static bool Recover(const std::filesystem::path& file);
  /// Recovers all that need it: when a server starts. Those that were, and, with what is wrong in `problem`,
  /// those that could not be.
  std::vector<StoredSession> RecoverAll();

 private:
  int HighestRun(const SessionLabels& labels) const;
  bool RunExists(const SessionLabels& labels) const;
  void MakeFolder() const;
  void RequireSpace() const;

  std::filesystem::path folder_;
  uint64_t min_free_bytes_;
  // Held while a session gets its name.
  std::mutex mutex_;
};

/// "sub-01_ses-1_task-reach_run-02_20261122T063200Z": the labels, and the start in UTC.
std::string SessionId(const SessionLabels& labels, int64_t start_wall_ns);

}  // namespace mwidth::record
