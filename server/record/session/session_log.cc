#include "server/record/session/session_log.h"

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>
#include <system_error>

#include <SQLiteCpp/Statement.h>
#include <fcntl.h>
#include <sqlite3.h>
#include <unistd.h>

namespace mwidth::record {
namespace {

// SQLite's own default, 4 MB.
constexpr int kCheckpointPages = 1000;

// A file descriptor of one's own: SQLite locks other files than this, so that closing it undoes no lock.
int OpenLog(const std::filesystem::path& file) {
  const int log = open((file.string() + "-wal").c_str(), O_RDWR | O_CLOEXEC);
  if (log < 0) {
    throw std::runtime_error(std::string("its log cannot be opened: ") + std::strerror(errno));
  }
  return log;
}

}  // namespace

SessionLog::SessionLog(const std::filesystem::path& file, SQLite::Database& writer)
    : writer_(writer),
      checkpointer_(file.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_NOMUTEX),
      log_file_(OpenLog(file)) {
  checkpointer_.exec("PRAGMA synchronous = NORMAL");
  sqlite3_wal_hook(writer_.getHandle(), &SessionLog::CountPages, this);
}

SessionLog::~SessionLog() {
  sqlite3_wal_hook(writer_.getHandle(), nullptr, nullptr);
  close(log_file_);
}

int SessionLog::CountPages(void* log, sqlite3*, const char*, int pages) {
  static_cast<SessionLog*>(log)->pages_ = pages;
  return SQLITE_OK;
}

// Passive: goes as far as readers let it, and waits for nobody. Syncs the log first, and the database last.
void SessionLog::Checkpoint() {
  try {
    checkpointer_.exec("PRAGMA wal_checkpoint(PASSIVE)");
  } catch (const SQLite::Exception& error) {
    // Of the syncs one may have failed; a disk without room shows when the database is written.
    doubtful_ = doubtful_ || error.getErrorCode() != SQLITE_FULL;
    throw;
  }
}

// A log of which a page is missing on the disk would, after a loss of power, bring old pages back into a
// database that is newer: so it is emptied, or this has failed. Writers wait meanwhile.
void SessionLog::Rewrite() {
  SQLite::Statement checkpoint(checkpointer_, "PRAGMA wal_checkpoint(TRUNCATE)");
  checkpoint.executeStep();
  if (checkpoint.getColumn(0).getInt() != 0) {
    throw std::runtime_error(
        "its log did not come to the disk, and cannot be written again while it is read");
  }
}

void SessionLog::Sync() {
  const std::lock_guard lock(mutex_);
  if (doubtful_) {
    Rewrite();
  } else if (pages_ >= kCheckpointPages) {
    Checkpoint();
  }
  if (fdatasync(log_file_) != 0) {
    doubtful_ = true;
    throw std::system_error(errno, std::generic_category(), "its log does not come to the disk");
  }
  doubtful_ = false;
}

}  // namespace mwidth::record
