#include "server/record/session/session_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>
#include <vector>

#include <SQLiteCpp/Database.h>
#include <fcntl.h>
#include <sqlite3.h>
#include <unistd.h>

#include "server/record/session/sample_codec.h"
#include "server/record/session/session_log.h"
#include "server/record/session/session_reader.h"
#include "server/record/session/session_rows.h"
#include "server/record/session/session_schema.h"
#include "server/record/session/stored_blocks.h"
#include "server/record/session/unmerged_samples.h"

namespace mwidth::record {
namespace {

constexpr mode_t kFileMode = 0640;
// How long a session waits for what keeps its log: readers at its end, a disk that failed before.
constexpr int kBusyTimeoutMs = 2000;

// Created here and not by SQLite, whose files the whole world may read.
void CreateFile(const std::filesystem::path& file) {
  const int descriptor = open(file.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, kFileMode);
  if (descriptor < 0) {
    throw StorageError(file.string() + " cannot be created: " + std::strerror(errno), errno == ENOSPC);
  }
  close(descriptor);
}

void RemoveFile(const std::filesystem::path& file) {
  for (const char* suffix : {"", "-wal", "-shm"}) {
    std::error_code ignored;
    std::filesystem::remove(file.string() + suffix, ignored);
  }
}

// The log into the file, the disk's own word for it included; then a single file that can be read without
// writing anything beside it. Readers that have it open keep the log's file, and those that read an older
// state of it what is behind that.
void LeaveLog(SQLite::Database& database) {
  database.setBusyTimeout(kBusyTimeoutMs);
  database.tryExec("PRAGMA wal_checkpoint(TRUNCATE)");
  database.setBusyTimeout(0);
  database.tryExec("PRAGMA journal_mode = DELETE");
}

}  // namespace

void SyncFolder(const std::filesystem::path& folder) {
  const int descriptor = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const bool synced = descriptor >= 0 && fsync(descriptor) == 0;
  const int reason = errno;
  if (descriptor >= 0) {
    close(descriptor);
  }
  if (!synced) {
    throw StorageError(folder.string() + " does not come to the disk: " + std::strerror(reason),
                       reason == ENOSPC);
  }
}

class SessionFile::Database {
 public:
  Database(const std::filesystem::path& file, const SessionInfo& info)
      : file_(file), info_(info), encoder_(info.axis), samples_(info.axis, kBlockSamples) {
    CreateFile(file);
    try {
      Guard([this] { CreateDatabase(); });
      SyncFolder(file.parent_path());
    } catch (const StorageError&) {
      log_.reset();
      rows_.reset();
      database_.reset();
      RemoveFile(file);
      throw;
    }
  }

  // Takes up an existing file, of which a reader said this.
  struct Existing {};
  Database(std::filesystem::path file, SessionInfo info, Existing)
      : file_(std::move(file)),
        info_(std::move(info)),
        encoder_(info_.axis),
        samples_(info_.axis, kBlockSamples) {
    Guard([this] {
      database_ =
          std::make_unique<SQLite::Database>(file_.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_NOMUTEX);
      OpenForWriting();
      blocks_ = database_->execAndGet("SELECT coalesce(max(number), 0) FROM blocks").getInt64();
      TakeUpTail();
    });
  }

  void Append(std::span<const exchange::Sample> samples, std::string_view lost_reason) {
    for (const exchange::Sample& sample : samples) {
      if (last_tick_ != 0 && sample.tick <= last_tick_) {
        continue;
      }
      if (last_tick_ != 0 && sample.tick != last_tick_ + 1) {
        NoteGap(sample, lost_reason);
      }
      samples_.Push(sample);
      last_tick_ = sample.tick;
      last_missed_ticks_ = sample.missed_ticks;
    }
  }

  void Commit() {
    Guard([this] {
      const bool only_tail = samples_.whole_blocks() == 0 && events.empty() && markers.empty() &&
                             gaps.empty() && steps.empty() && !info_changed_;
      // A statement of its own is a transaction of its own, at less cost.
      if (only_tail) {
        WriteSamples();
      } else {
        rows_->Begin();
        WritePending();
        rows_->Commit();
      }
    });
    blocks_ += static_cast<int64_t>(samples_.whole_blocks());
    ++tail_rows_;
    samples_.Committed();
    info_changed_ = false;
    events.clear();
    markers.clear();
    gaps.clear();
    steps.clear();
  }

  // By another thread than the rest, so it leaves the connection alone.
  void Sync() {
    try {
      if (log_) {
        log_->Sync();
      }
    } catch (const SQLite::Exception& error) {
      throw StorageError(file_.string() + " cannot be written: " + error.what(),
                         error.getErrorCode() == SQLITE_FULL);
    } catch (const std::system_error& error) {
      throw StorageError(file_.string() + " cannot be written: " + error.what(),
                         error.code() == std::errc::no_space_on_device);
    } catch (const std::runtime_error& error) {
      throw StorageError(file_.string() + " cannot be written: " + error.what(), false);
    }
  }

  void End(SessionState state, std::optional<int64_t> end_wall_ns, const std::optional<Gap>& last_gap) {
    info_.state = state;
    info_.end_wall_ns = end_wall_ns;
    info_changed_ = true;
    last_gap_ = last_gap;
    samples_.Close();
    try {
      Commit();
      Sync();
    } catch (const StorageError&) {
      // The next commit says so, whether the end came into the file or not.
      info_.state = SessionState::kOpen;
      info_.end_wall_ns.reset();
      info_changed_ = true;
      last_gap_.reset();
      throw;
    }
    log_.reset();
    LeaveLog(*database_);
  }

  bool HasPending() const {
    return samples_.pending() > 0 || !events.empty() || !markers.empty() || !gaps.empty() || !steps.empty() ||
           info_changed_;
  }
  std::size_t pending_samples() const { return samples_.pending(); }

  std::vector<Event> events;
  std::vector<Marker> markers;
  std::vector<Gap> gaps;
  std::vector<WallClockStep> steps;

 private:
  // Errors as StorageError, with the transaction undone.
  template <typename Action>
  void Guard(const Action& action) {
    try {
      action();
    } catch (const SQLite::Exception& error) {
      if (database_ && sqlite3_get_autocommit(database_->getHandle()) == 0) {
        database_->tryExec("ROLLBACK");
      }
      throw StorageError(file_.string() + " cannot be written: " + error.what(),
                         error.getErrorCode() == SQLITE_FULL);
    } catch (const std::runtime_error& error) {  // of the log
      throw StorageError(file_.string() + " cannot be written: " + error.what(), false);
    }
  }

  // What the tail has becomes blocks when the session ends.
  void TakeUpTail() {
    BlockTable tail(*database_, "tail");
    SampleDecoder decoder(info_.axis);
    std::vector<exchange::Sample> samples;
    while (const auto row = tail.Next(static_cast<uint64_t>(tail_rows_), 0, decoder, samples)) {
      tail_rows_ = static_cast<int64_t>(row->number);
      if (!row->damage.empty()) {
        gaps.push_back({.after_tick = row->first_tick - 1,
                        .before_tick = row->last_tick + 1,
                        .missed_ticks = 0,
                        .lost_ticks = row->samples,
                        .reason = "a row of the tail was damaged: " + row->damage});
      }
      for (const exchange::Sample& sample : samples) {
        samples_.Push(sample);
      }
    }
    samples_.FoundInTail();
  }

  void CreateDatabase() {
    database_ =
        std::make_unique<SQLite::Database>(file_.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_NOMUTEX);

    database_->exec("PRAGMA journal_mode = WAL");
    database_->exec("PRAGMA synchronous = FULL");
    database_->exec("BEGIN IMMEDIATE");
    CreateTables(*database_);
    WriteInfo(info_, *database_);
    database_->exec("COMMIT");
    OpenForWriting();
  }

  // Of a database in WAL mode. From here on commits wait for no disk: Sync does.
  void OpenForWriting() {
    database_->exec("PRAGMA synchronous = NORMAL");
    database_->setBusyTimeout(kBusyTimeoutMs);  // for a log that is written again
    rows_ = std::make_unique<SessionRows>(*database_);
    log_ = std::make_unique<SessionLog>(file_, *database_);
  }

  void NoteGap(const exchange::Sample& sample, std::string_view lost_reason) {
    const uint64_t absent = sample.tick - last_tick_ - 1;
    const uint64_t missed = std::min(absent, sample.missed_ticks - last_missed_ticks_);
    gaps.push_back({.after_tick = last_tick_,
                    .before_tick = sample.tick,
                    .missed_ticks = missed,
                    .lost_ticks = absent - missed,
                    .reason = missed == absent ? "the loop missed its deadlines" : std::string(lost_reason)});
  }

  void WritePending() {
    WriteSamples();
    const auto insert = [this](const auto& rows) {
      for (const auto& row : rows) {
        rows_->Insert(row);
      }
    };
    insert(events);
    insert(markers);
    insert(gaps);
    insert(steps);
    if (info_changed_) {
      WriteInfo(info_, *database_);
      WriteLastGap();
    }
  }

  // Nothing else has no tick behind it.
  void WriteLastGap() {
    if (last_gap_) {
      rows_->Insert(*last_gap_);
    } else if (info_.state == SessionState::kOpen) {
      database_->exec("DELETE FROM gaps WHERE before_tick = 0");
    }
  }

  void WriteSamples() {
    for (std::size_t i = 0; i < samples_.whole_blocks(); ++i) {
      const CheckedSamples block = samples_.block(i);
      rows_->InsertBlock(blocks_ + 1 + static_cast<int64_t>(i), block.samples,
                         encoder_.Encode(block, Packing::kCompressed));
    }
    if (samples_.whole_blocks() > 0) {
      rows_->ClearTail();
    }
    const CheckedSamples tail = samples_.tail();
    if (!tail.samples.empty()) {
      rows_->InsertTail(tail_rows_ + 1, tail.samples, encoder_.Encode(tail, Packing::kPlain));
    }
  }

  std::filesystem::path file_;
  SessionInfo info_;
  SampleEncoder encoder_;
  std::unique_ptr<SQLite::Database> database_;
  std::unique_ptr<SessionRows> rows_;
  std::unique_ptr<SessionLog> log_;
  UnmergedSamples samples_;
  // The largest numbers so far; of the tail an upper bound, for no number may come twice.
  int64_t blocks_ = 0;
  int64_t tail_rows_ = 0;
  // The session was ended, or its end failed and it goes on.
  bool info_changed_ = false;
  std::optional<Gap> last_gap_;
  uint64_t last_tick_ = 0;
  uint64_t last_missed_ticks_ = 0;
};

SessionFile::SessionFile(const std::filesystem::path& file, const SessionInfo& info)
    : database_(std::make_unique<Database>(file, info)) {}
SessionFile::SessionFile(std::unique_ptr<Database> database) : database_(std::move(database)) {}
SessionFile SessionFile::Reopen(const std::filesystem::path& file) {
  const SessionInfo info = SessionReader(file).info();
  return SessionFile(std::make_unique<Database>(file, info, Database::Existing{}));
}
SessionFile::SessionFile(SessionFile&&) noexcept = default;
SessionFile& SessionFile::operator=(SessionFile&&) noexcept = default;
SessionFile::~SessionFile() = default;

void SessionFile::Append(std::span<const exchange::Sample> samples, std::string_view lost_reason) {
  database_->Append(samples, lost_reason);
}
void SessionFile::Add(const Event& event) { database_->events.push_back(event); }
void SessionFile::Add(const Marker& marker) { database_->markers.push_back(marker); }
void SessionFile::Add(const Gap& gap) { database_->gaps.push_back(gap); }
void SessionFile::Add(const WallClockStep& step) { database_->steps.push_back(step); }
bool SessionFile::HasPending() const { return database_->HasPending(); }
std::size_t SessionFile::pending_samples() const { return database_->pending_samples(); }
void SessionFile::Commit(Durability durability) {
  database_->Commit();
  if (durability == Durability::kPower) {
    database_->Sync();
  }
}
void SessionFile::Sync() { database_->Sync(); }
void SessionFile::End(SessionState state, std::optional<int64_t> end_wall_ns,
                      const std::optional<Gap>& last_gap) {
  database_->End(state, end_wall_ns, last_gap);
}
void SessionFile::Settle(const std::filesystem::path& file) {
  try {
    SQLite::Database database(file.string(), SQLite::OPEN_READWRITE);
    LeaveLog(database);
  } catch (const SQLite::Exception& error) {
    throw StorageError(file.string() + " cannot be written: " + error.what(),
                       error.getErrorCode() == SQLITE_FULL);
  }
}

}  // namespace mwidth::record
