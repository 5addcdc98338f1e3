// The write-ahead log of a session's database: when it comes to the disk, and into the database.
#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <mutex>

#include <SQLiteCpp/Database.h>

namespace mwidth::record {

/// Takes over from the writer's connection what waits for the disk, for a thread that may wait. SQLite writes
/// to the log in order and recovers whatever of it is whole, so the log on the disk is the commits on the
/// disk; a checkpoint by a connection of its own, which holds up no writer, keeps the log short. Any thread.
class SessionLog {
 public:
  /// `writer` has committed to `file` in WAL mode and leaves checkpoints to this from now on; it outlives it.
  /// Throws SQLite::Exception, or std::runtime_error where the log cannot be opened.
  SessionLog(const std::filesystem::path& file, SQLite::Database& writer);
  SessionLog(const SessionLog&) = delete;
  SessionLog& operator=(const SessionLog&) = delete;
  ~SessionLog();

  /// Returns when every commit before it is on the disk. Throws as the constructor (std::system_error where
  /// the system tells why). The system tells a write that failed once, and forgets what it could not write:
  /// after a failure this only returns when it has written and synced again, into the database, all that the
  /// log has, as it is cached, and has begun the log anew.
  void Sync();

 private:
  void Checkpoint();
  void Rewrite();

  static int CountPages(void* log, sqlite3*, const char*, int pages);

  SQLite::Database& writer_;
  std::mutex mutex_;
  SQLite::Database checkpointer_;
  int log_file_;
  // Nobody knows what the disk has of the log.
  bool doubtful_ = false;
  // Pages in the log since it was last begun anew.
  std::atomic<int> pages_ = 0;
};

}  // namespace mwidth::record
