#include "server/record/session/session_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>
#include <fcntl.h>
#include <sqlite3.h>
#include <unistd.h>

#include "server/record/session/sample_codec.h"
#include "server/record/session/session_schema.h"

namespace mwidth::record {
namespace {

constexpr mode_t kFileMode = 0640;

// Created here and not by SQLite, whose files the whole world may read.
std::string CreateFile(const std::filesystem::path& file) {
  const int descriptor = open(file.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, kFileMode);
  if (descriptor < 0) {
    throw StorageError(file.string() + " cannot be created: " + std::strerror(errno), errno == ENOSPC);
  }
  close(descriptor);
  return file.string();
}

// So that the file is found after a loss of power.
void SyncFolder(const std::filesystem::path& file) {
  const int folder = open(file.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder >= 0) {
    fsync(folder);
    close(folder);
  }
}

void BindBlock(SQLite::Statement& insert, int64_t number, std::span<const exchange::Sample> samples,
               std::span<const std::byte> bytes) {
  insert.tryReset();
  insert.bind(1, number);
  insert.bind(2, static_cast<int64_t>(samples.front().tick));
  insert.bind(3, static_cast<int64_t>(samples.back().tick));
  insert.bind(4, static_cast<int64_t>(samples.size()));
  insert.bind(5, static_cast<int64_t>(Checksum(bytes)));
  insert.bindNoCopy(6, bytes.data(), static_cast<int>(bytes.size()));
}

}  // namespace

class SessionFile::Database {
 public:
  Database(const std::filesystem::path& file, const SessionInfo& info)
      : file_(file), info_(info), encoder_(info.axis) {
    const std::string created = CreateFile(file);
    try {
      Guard([&] {
        database_ = std::make_unique<SQLite::Database>(created, SQLite::OPEN_READWRITE);
        database_->exec("PRAGMA journal_mode = WAL");
        database_->exec("PRAGMA synchronous = FULL");
        database_->exec("BEGIN IMMEDIATE");
        CreateTables(*database_);
        WriteInfo(info, *database_);
        database_->exec("COMMIT");
        statements_ = std::make_unique<Statements>(*database_);
      });
    } catch (const StorageError&) {
      database_.reset();
      for (const char* suffix : {"", "-wal", "-shm"}) {
        std::error_code ignored;
        std::filesystem::remove(created + suffix, ignored);
      }
      throw;
    }
    SyncFolder(file);
  }

  void Append(std::span<const exchange::Sample> samples, std::string_view lost_reason) {
    for (const exchange::Sample& sample : samples) {
      if (last_ && sample.tick <= last_->tick) {
        continue;
      }
      if (last_ && sample.tick != last_->tick + 1) {
        NoteGap(sample, lost_reason);
      }
      samples_.push_back(sample);
      last_ = sample;
    }
  }

  void Commit(Durability durability) {
    Guard([&] {
      // Not within a transaction, as SQLite has it.
      database_->exec(durability == Durability::kPower ? "PRAGMA synchronous = FULL"
                                                       : "PRAGMA synchronous = NORMAL");
      Execute(statements_->begin);
      WritePending();
      Execute(statements_->commit);
    });
    samples_.erase(samples_.begin(), samples_.begin() + static_cast<std::ptrdiff_t>(merged_));
    committed_ = samples_.size();
    blocks_ += new_blocks_;
    ++tail_rows_;
    events.clear();
    markers.clear();
    gaps.clear();
    steps.clear();
  }

  void End(SessionState state, std::optional<int64_t> end_wall_ns) {
    ending_ = true;
    info_.state = state;
    info_.end_wall_ns = end_wall_ns;
    Commit(Durability::kPower);
    // A single file that can be read without writing anything beside it. Refused while somebody reads it, and
    // then a reader must make do with the write-ahead log.
    Guard([&] { database_->tryExec("PRAGMA journal_mode = DELETE"); });
  }

  bool HasPending() const {
    return committed_ < samples_.size() || !events.empty() || !markers.empty() || !gaps.empty() ||
           !steps.empty();
  }
  std::size_t pending_samples() const { return samples_.size() - committed_; }

  std::vector<Event> events;
  std::vector<Marker> markers;
  std::vector<Gap> gaps;
  std::vector<WallClockStep> steps;

 private:
  struct Statements {
    explicit Statements(SQLite::Database& database)
        : begin(database, "BEGIN IMMEDIATE"),
          commit(database, "COMMIT"),
          block(database, "INSERT INTO blocks VALUES(?, ?, ?, ?, ?, ?)"),
          tail(database, "INSERT INTO tail VALUES(?, ?, ?, ?, ?, ?)"),
          clear_tail(database, "DELETE FROM tail"),
          event(database,
                "INSERT INTO events(number, kind, tick, monotonic_ns, message, metadata) "
                "VALUES(?, ?, ?, ?, ?, ?)"),
          marker(database, "INSERT INTO markers VALUES(?, ?, ?, ?, ?, ?, ?, ?)"),
          gap(database,
              "INSERT INTO gaps(after_tick, before_tick, missed_ticks, lost_ticks, reason) "
              "VALUES(?, ?, ?, ?, ?)"),
          step(database, "INSERT INTO wall_clock_steps(monotonic_ns, offset_ns) VALUES(?, ?)") {}

    SQLite::Statement begin, commit, block, tail, clear_tail, event, marker, gap, step;
  };

  // What SQLite throws, as StorageError, with the transaction undone.
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
    }
  }

  static void Execute(SQLite::Statement& statement) {
    statement.tryReset();
    statement.exec();
    statement.tryReset();
  }

  void NoteGap(const exchange::Sample& sample, std::string_view lost_reason) {
    const uint64_t absent = sample.tick - last_->tick - 1;
    const uint64_t missed = std::min(absent, sample.missed_ticks - last_->missed_ticks);
    gaps.push_back({.after_tick = last_->tick,
                    .before_tick = sample.tick,
                    .missed_ticks = missed,
                    .lost_ticks = absent - missed,
                    .reason = missed == absent ? "the loop missed its deadlines" : std::string(lost_reason)});
  }

  // Where the block that begins at `begin` ends, and whether nothing can be added to it any more.
  std::pair<std::size_t, bool> BlockEnd(std::size_t begin) const {
    for (std::size_t i = begin + 1; i < samples_.size(); ++i) {
      if (i - begin == kBlockSamples || !Follows(samples_[i - 1], samples_[i])) {
        return {i, true};
      }
    }
    return {samples_.size(), ending_ || samples_.size() - begin == kBlockSamples};
  }

  void WritePending() {
    WriteSamples();
    for (const Event& event : events) {
      Write(event);
    }
    for (const Marker& marker : markers) {
      Write(marker);
    }
    for (const Gap& gap : gaps) {
      Write(gap);
    }
    for (const WallClockStep& step : steps) {
      statements_->step.bind(1, step.monotonic_ns);
      statements_->step.bind(2, step.offset_ns);
      Execute(statements_->step);
    }
    if (ending_) {
      WriteInfo(info_, *database_);
    }
  }

  void WriteSamples() {
    merged_ = 0;
    new_blocks_ = 0;
    while (merged_ < samples_.size()) {
      const auto [end, whole] = BlockEnd(merged_);
      if (!whole) {
        break;
      }
      WriteBlock(statements_->block, blocks_ + ++new_blocks_, merged_, end, Packing::kCompressed);
      merged_ = end;
    }
    if (merged_ > 0) {
      Execute(statements_->clear_tail);
    }
    const std::size_t begin = std::max(merged_, committed_);
    if (begin < samples_.size()) {
      WriteBlock(statements_->tail, tail_rows_ + 1, begin, samples_.size(), Packing::kPlain);
    }
  }

  void WriteBlock(SQLite::Statement& insert, int64_t number, std::size_t begin, std::size_t end,
                  Packing packing) {
    const auto samples = std::span(samples_).subspan(begin, end - begin);
    BindBlock(insert, number, samples, encoder_.Encode(samples, packing));
    Execute(insert);
  }

  void Write(const Event& event) {
    SQLite::Statement& insert = statements_->event;
    insert.bind(1, static_cast<int64_t>(event.number));
    insert.bind(2, static_cast<int>(event.kind));
    insert.bind(3, static_cast<int64_t>(event.tick));
    insert.bind(4, event.monotonic_ns);
    insert.bind(5, event.message);
    insert.bind(6, MetadataText(event.metadata));
    Execute(insert);
  }

  void Write(const Marker& marker) {
    SQLite::Statement& insert = statements_->marker;
    insert.bind(1, static_cast<int64_t>(marker.number));
    insert.bind(2, marker.label);
    insert.bind(3, marker.kind);
    insert.bind(4, MetadataText(marker.metadata));
    insert.bind(5, marker.monotonic_ns);
    insert.bind(6, marker.error_ns);
    insert.bind(7, marker.arrival_ns);
    insert.bind(8, marker.client_ns);
    Execute(insert);
  }

  void Write(const Gap& gap) {
    SQLite::Statement& insert = statements_->gap;
    insert.bind(1, static_cast<int64_t>(gap.after_tick));
    insert.bind(2, static_cast<int64_t>(gap.before_tick));
    insert.bind(3, static_cast<int64_t>(gap.missed_ticks));
    insert.bind(4, static_cast<int64_t>(gap.lost_ticks));
    insert.bind(5, gap.reason);
    Execute(insert);
  }

  std::filesystem::path file_;
  SessionInfo info_;
  SampleEncoder encoder_;
  std::unique_ptr<SQLite::Database> database_;
  std::unique_ptr<Statements> statements_;
  // Those behind the last block: the first `committed_` are in the tail; the last transaction made blocks of
  // the first `merged_`.
  std::vector<exchange::Sample> samples_;
  std::size_t committed_ = 0;
  std::size_t merged_ = 0;
  // The largest numbers so far; of the tail an upper bound, for no number may come twice. That transaction's.
  int64_t blocks_ = 0;
  int64_t tail_rows_ = 0;
  int64_t new_blocks_ = 0;
  bool ending_ = false;
  std::optional<exchange::Sample> last_;
};

SessionFile::SessionFile(const std::filesystem::path& file, const SessionInfo& info)
    : database_(std::make_unique<Database>(file, info)) {}
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
void SessionFile::Commit(Durability durability) { database_->Commit(durability); }
void SessionFile::End(SessionState state, std::optional<int64_t> end_wall_ns) {
  database_->End(state, end_wall_ns);
}

}  // namespace mwidth::record
