#include "server/record/session/session_reader.h"

#include <algorithm>
#include <optional>
#include <utility>

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>
#include <sqlite3.h>

#include "server/record/session/sample_codec.h"
#include "server/record/session/session_schema.h"
#include "server/record/session/stored_blocks.h"

namespace mwidth::record {
namespace {

// How long a reader waits for a server that is just ending the session.
constexpr int kBusyTimeoutMs = 2000;

bool IsSession(SQLite::Database& database) {
  return database.execAndGet("PRAGMA application_id").getInt() == kSessionApplicationId;
}

// True where there is no log beside the file, or one with nothing in it.
bool LogIsEmpty(const std::filesystem::path& file) {
  std::error_code none;
  const auto size = std::filesystem::file_size(file.string() + "-wal", none);
  return none || size == 0;
}

// As SQLite takes names with options behind them.
std::string UriOf(const std::filesystem::path& file) {
  std::string uri = "file:";
  for (const char c : file.string()) {
    uri += c == '%' ? "%25" : c == '?' ? "%3f" : c == '#' ? "%23" : std::string(1, c);
  }
  return uri;
}

SQLite::Database Open(const std::filesystem::path& file) {
  const auto open = [&](const std::string& name, int flags) {
    SQLite::Database database(name, SQLite::OPEN_READONLY | flags, kBusyTimeoutMs);
    IsSession(database);  // the file is first read here
    return database;
  };
  try {
    return open(file.string(), 0);
  } catch (const SQLite::Exception& error) {
    // A folder that cannot be written has no place for a log, and a file in it that has none needs none.
    if (error.getErrorCode() != SQLITE_CANTOPEN || !std::filesystem::exists(file) || !LogIsEmpty(file)) {
      throw;
    }
    return open(UriOf(file) + "?immutable=1", SQLite::OPEN_URI);
  }
}

std::vector<Event> ReadEvents(SQLite::Database& database) {
  std::vector<Event> events;
  SQLite::Statement rows(
      database, "SELECT number, kind, tick, monotonic_ns, message, metadata FROM events ORDER BY number, id");
  while (rows.executeStep()) {
    const int64_t kind = rows.getColumn(1).getInt64();
    const bool known = kind >= 0 && kind <= static_cast<int64_t>(EventKind::kServerStopping);
    events.push_back({.number = static_cast<uint64_t>(rows.getColumn(0).getInt64()),
                      .kind = known ? static_cast<EventKind>(kind) : EventKind::kUnknown,
                      .tick = static_cast<uint64_t>(rows.getColumn(2).getInt64()),
                      .monotonic_ns = rows.getColumn(3).getInt64(),
                      .message = rows.getColumn(4).getString(),
                      .metadata = MetadataOf(rows.getColumn(5).getString())});
  }
  return events;
}

std::vector<Marker> ReadMarkers(SQLite::Database& database) {
  std::vector<Marker> markers;
  SQLite::Statement rows(
      database,
      "SELECT number, label, kind, metadata, monotonic_ns, error_ns, arrival_ns, client_ns "
      "FROM markers ORDER BY number");
  while (rows.executeStep()) {
    markers.push_back({.number = static_cast<uint64_t>(rows.getColumn(0).getInt64()),
                       .label = rows.getColumn(1).getString(),
                       .kind = rows.getColumn(2).getString(),
                       .metadata = MetadataOf(rows.getColumn(3).getString()),
                       .monotonic_ns = rows.getColumn(4).getInt64(),
                       .error_ns = rows.getColumn(5).getInt64(),
                       .arrival_ns = rows.getColumn(6).getInt64(),
                       .client_ns = rows.getColumn(7).getInt64()});
  }
  return markers;
}

std::vector<Gap> ReadGaps(SQLite::Database& database) {
  std::vector<Gap> gaps;
  SQLite::Statement rows(
      database,
      "SELECT after_tick, before_tick, missed_ticks, lost_ticks, reason FROM gaps ORDER BY after_tick, id");
  while (rows.executeStep()) {
    gaps.push_back({.after_tick = static_cast<uint64_t>(rows.getColumn(0).getInt64()),
                    .before_tick = static_cast<uint64_t>(rows.getColumn(1).getInt64()),
                    .missed_ticks = static_cast<uint64_t>(rows.getColumn(2).getInt64()),
                    .lost_ticks = static_cast<uint64_t>(rows.getColumn(3).getInt64()),
                    .reason = rows.getColumn(4).getString()});
  }
  return gaps;
}

std::vector<WallClockStep> ReadSteps(SQLite::Database& database) {
  std::vector<WallClockStep> steps;
  SQLite::Statement rows(database,
                         "SELECT monotonic_ns, offset_ns FROM wall_clock_steps ORDER BY monotonic_ns, id");
  while (rows.executeStep()) {
    steps.push_back(
        {.monotonic_ns = rows.getColumn(0).getInt64(), .offset_ns = rows.getColumn(1).getInt64()});
  }
  return steps;
}

}  // namespace

class SessionReader::File {
 public:
  explicit File(const std::filesystem::path& file) : path(file), database(Open(file)) {
    if (!IsSession(database)) {
      throw SessionFileError(file.string() + " is a database, but no session");
    }
    const int format = database.execAndGet("PRAGMA user_version").getInt();
    if (format != kSessionFormat) {
      throw SessionFileError(file.string() + " is of format " + std::to_string(format) +
                             "; this program reads format " + std::to_string(kSessionFormat) +
                             ": read it with the version that wrote it, or a newer one");
    }
    info = ReadInfo(database);
    info.id = file.stem().string();
    blocks.emplace(database, info.axis);
    try {
      CountSamples(database, info);
    } catch (const SQLite::Exception&) {  // a page is damaged: what the others have can be read
      blocks->Count(info);
    }
  }

  // A table that cannot be read, in the words of a person.
  template <typename Read>
  auto Table(const char* name, const Read& read) {
    try {
      return read(database);
    } catch (const SQLite::Exception& error) {
      throw SessionFileError(path.string() + ": its " + name + " cannot be read: " + error.what());
    }
  }

  std::filesystem::path path;
  SQLite::Database database;
  SessionInfo info;
  std::optional<StoredBlocks> blocks;
};

SessionReader::SessionReader(const std::filesystem::path& file) {
  try {
    file_ = std::make_unique<File>(file);
  } catch (const SessionFileError&) {
    throw;
  } catch (const std::runtime_error& error) {  // SQLite::Exception, too
    throw SessionFileError(file.string() + " cannot be read as a session: " + error.what());
  }
}

SessionReader::SessionReader(SessionReader&&) noexcept = default;
SessionReader& SessionReader::operator=(SessionReader&&) noexcept = default;
SessionReader::~SessionReader() = default;

const SessionInfo& SessionReader::info() const { return file_->info; }
std::vector<Event> SessionReader::Events() const { return file_->Table("events", ReadEvents); }
std::vector<Marker> SessionReader::Markers() const { return file_->Table("markers", ReadMarkers); }
std::vector<WallClockStep> SessionReader::WallClockSteps() const {
  return file_->Table("wall clock steps", ReadSteps);
}

std::vector<Gap> SessionReader::NotedGaps() const { return file_->Table("gaps", ReadGaps); }

std::vector<Gap> SessionReader::Gaps() const {
  std::vector<Gap> gaps = NotedGaps();
  const std::vector<Gap> damage = file_->blocks->GapsOfDamage();
  gaps.insert(gaps.end(), damage.begin(), damage.end());
  std::stable_sort(gaps.begin(), gaps.end(),
                   [](const Gap& a, const Gap& b) { return a.after_tick < b.after_tick; });
  return gaps;
}

bool SessionReader::Next(std::vector<exchange::Sample>& samples) { return file_->blocks->Next(samples); }
void SessionReader::Seek(uint64_t tick) { file_->blocks->Seek(tick); }
const std::vector<DamagedBlock>& SessionReader::damaged() const { return file_->blocks->damaged(); }

std::vector<DamagedBlock> SessionReader::Verify() {
  std::vector<DamagedBlock> problems;
  const auto tell = [&problems](const std::string& reason) {
    problems.push_back({.number = 0, .first_tick = 0, .last_tick = 0, .reason = reason});
  };
  try {
    SQLite::Statement check(file_->database, "PRAGMA integrity_check");
    while (check.executeStep()) {
      const std::string row = check.getColumn(0).getString();
      if (row != "ok") {
        tell("the database: " + row);
      }
    }
  } catch (const SQLite::Exception& error) {
    tell(std::string("the database cannot be checked: ") + error.what());
  }
  try {
    const std::vector<DamagedBlock> blocks = file_->blocks->Verify(ReadGaps(file_->database));
    problems.insert(problems.end(), blocks.begin(), blocks.end());
    Events();
    Markers();
    WallClockSteps();
  } catch (const std::runtime_error& error) {
    tell(error.what());
  }
  return problems;
}

}  // namespace mwidth::record
