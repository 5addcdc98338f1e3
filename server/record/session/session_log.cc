#include "server/record/session/session_log.h"

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>

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

void SessionLog::Sync() {
  const std::lock_guard lock(mutex_);
  if (pages_ >= kCheckpointPages) {
    // Syncs the log, too. Passive: goes as far as readers let it, and waits for nobody.
    checkpointer_.exec("PRAGMA wal_checkpoint(PASSIVE)");
  }
  if (fdatasync(log_file_) != 0) {
    throw std::runtime_error(std::string("its log does not come to the disk: ") + std::strerror(errno));
  }
}

}  // namespace mwidth::record
