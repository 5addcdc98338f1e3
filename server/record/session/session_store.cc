#include "server/record/session/session_store.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <ctime>
#include <utility>

#include <sys/statvfs.h>

#include "server/record/session/session_reader.h"
#include "server/record/session/session_recovery.h"

namespace mwidth::record {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExtension = ".sqlite";
constexpr uint64_t kBytesPerMb = 1'000'000;

// The part of a session's id before the number of its run.
std::string TaskPrefix(const SessionLabels& labels) {
  return "sub-" + labels.subject + (labels.visit.empty() ? "" : "_ses-" + labels.visit) + "_task-" +
         labels.task + "_run-";
}

// The run of a session of this prefix, from its id; 0 where it is another's.
int RunOf(const std::string& id, const std::string& prefix) {
  int run = 0;
  if (id.starts_with(prefix)) {
    const char* end = id.data() + id.size();
    const auto [rest, error] = std::from_chars(id.data() + prefix.size(), end, run);
    return error == std::errc() && rest != end && *rest == '_' ? run : 0;
  }
  return 0;
}

std::vector<fs::path> FilesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  if (fs::exists(folder)) {
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
      if (entry.path().extension() == kExtension && entry.is_regular_file()) {
        files.push_back(entry.path());
      }
    }
  }
  return files;
}

// 0 where there is no such file.
uint64_t BytesOf(const fs::path& file) {
  std::error_code none;
  const auto size = fs::file_size(file, none);
  return none ? 0 : size;
}

uint64_t LogBytes(const fs::path& file) { return BytesOf(file.string() + "-wal"); }

}  // namespace

std::string SessionId(const SessionLabels& labels, int64_t start_wall_ns) {
  const auto seconds = static_cast<std::time_t>(start_wall_ns / 1'000'000'000);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  std::array<char, 32> time{};
  std::strftime(time.data(), time.size(), "%Y%m%dT%H%M%SZ", &utc);
  const std::string run = std::to_string(labels.run);
  return TaskPrefix(labels) + (run.size() < 2 ? "0" : "") + run + "_" + time.data();
}

SessionStore::SessionStore(fs::path folder, uint64_t min_free_bytes)
    : folder_(std::move(folder)), min_free_bytes_(min_free_bytes) {}

StoredSession SessionStore::Examine(const fs::path& file) {
  StoredSession session{.id = file.stem().string(),
                        .file = file,
                        .file_bytes = BytesOf(file) + LogBytes(file),
                        .info = {},
                        .problem = "",
                        .recording = SessionLock::Held(file)};
  try {
    session.info = SessionReader(file).info();
  } catch (const SessionFileError& error) {
    session.problem = error.what();
  }
  return session;
}

std::vector<StoredSession> SessionStore::List() const {
  std::vector<StoredSession> sessions;
  for (const fs::path& file : FilesIn(folder_)) {
    sessions.push_back(Examine(file));
  }
  const auto start = [](const StoredSession& session) {
    return std::pair(session.info ? session.info->start_wall_ns : 0, session.id);
  };
  std::sort(sessions.begin(), sessions.end(),
            [&start](const StoredSession& a, const StoredSession& b) { return start(a) > start(b); });
  return sessions;
}

std::optional<fs::path> SessionStore::PathOf(std::string_view id) const {
  constexpr std::string_view kAllowed = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_";
  if (id.empty() || id.size() > 250 || id.find_first_not_of(kAllowed) != std::string_view::npos) {
    return std::nullopt;
  }
  fs::path file = folder_ / (std::string(id) + kExtension);
  std::error_code none;
  return fs::is_regular_file(file, none) ? std::optional(std::move(file)) : std::nullopt;
}

int SessionStore::HighestRun(const SessionLabels& labels) const {
  int highest = 0;
  const std::string prefix = TaskPrefix(labels);
  for (const fs::path& file : FilesIn(folder_)) {
    highest = std::max(highest, RunOf(file.stem().string(), prefix));
  }
  return highest;
}

bool SessionStore::RunExists(const SessionLabels& labels) const {
  const std::string prefix = TaskPrefix(labels);
  const std::vector<fs::path> files = FilesIn(folder_);
  return std::any_of(files.begin(), files.end(),
                     [&](const fs::path& file) { return RunOf(file.stem().string(), prefix) == labels.run; });
}

void SessionStore::RequireSpace() const {
  struct statvfs status {};
  if (statvfs(folder_.c_str(), &status) != 0) {
    throw SessionRefused(
        SessionRefusal::kStorageFailed,
        "the folder of sessions " + folder_.string() + " cannot be looked into: " + std::strerror(errno));
  }
  const uint64_t free = uint64_t{status.f_bavail} * status.f_frsize;
  if (free < min_free_bytes_) {
    throw SessionRefused(SessionRefusal::kStorageFull, "only " + std::to_string(free / kBytesPerMb) +
                                                           " MB are free in " + folder_.string() +
                                                           ", and a session begins only where there are " +
                                                           std::to_string(min_free_bytes_ / kBytesPerMb) +
                                                           " MB: make room, then start again");
  }
}

// And those above it, with their names on the disk.
void SessionStore::MakeFolder() const {
  std::vector<fs::path> made;
  for (fs::path folder = fs::absolute(folder_).lexically_normal(); !fs::exists(folder);
       folder = folder.parent_path()) {
    made.push_back(folder);
  }
  fs::create_directories(folder_);
  for (const fs::path& folder : made) {
    SyncFolder(folder.parent_path());
  }
}

NewSession SessionStore::Create(SessionInfo info) {
  const std::lock_guard lock(mutex_);
  try {
    MakeFolder();
    RequireSpace();
    if (info.labels.run == 0) {
      info.labels.run = HighestRun(info.labels) + 1;
    } else if (RunExists(info.labels)) {
      throw SessionRefused(SessionRefusal::kSessionExists,
                           "run " + std::to_string(info.labels.run) + " of task " + info.labels.task +
                               " by subject " + info.labels.subject + " exists: give run " +
                               std::to_string(HighestRun(info.labels) + 1) +
                               ", or 0 for the next one that is free");
    }
    info.id = SessionId(info.labels, info.start_wall_ns);
    const fs::path path = folder_ / (info.id + kExtension);
    auto held = SessionLock::Take(path);
    if (!held) {
      throw SessionRefused(errno == ENOSPC ? SessionRefusal::kStorageFull : SessionRefusal::kStorageFailed,
                           "the session " + path.string() + " cannot be locked: " + std::strerror(errno));
    }
    SessionFile file(path, info);
    return {.info = info, .path = path, .lock = std::move(*held), .file = std::move(file)};
  } catch (const StorageError& error) {
    throw SessionRefused(error.disk_full() ? SessionRefusal::kStorageFull : SessionRefusal::kStorageFailed,
                         std::string(error.what()) +
                             (error.disk_full() ? ": make room, then start again"
                                                : ": see to the disk and to the permissions of the folder"));
  } catch (const fs::filesystem_error& error) {
    throw SessionRefused(error.code() == std::errc::no_space_on_device ? SessionRefusal::kStorageFull
                                                                       : SessionRefusal::kStorageFailed,
                         std::string("the folder of sessions cannot be used: ") + error.what());
  }
}

void SessionStore::Discard(const fs::path& file) {
  for (const char* suffix : {"", "-wal", "-shm"}) {
    std::error_code ignored;
    fs::remove(file.string() + suffix, ignored);
  }
}

bool SessionStore::Recover(const fs::path& file) {
  const auto is_open = [&file] { return SessionReader(file).info().state == SessionState::kOpen; };
  const bool has_log = LogBytes(file) > 0;  // before a reader makes one that is empty
  if (!is_open() && !has_log) {
    return false;
  }
  const auto lock = SessionLock::Take(file);
  if (!lock) {
    if (errno == EWOULDBLOCK) {
      return false;
    }
    throw StorageError(file.string() + " cannot be locked: " + std::strerror(errno), errno == ENOSPC);
  }
  // Once more: it may have been ended, or recovered, between the two.
  if (!is_open()) {
    if (has_log) {
      SessionFile::Settle(file);
    }
    return false;
  }
  RecoverSession(file);
  return true;
}

std::vector<StoredSession> SessionStore::RecoverAll() {
  std::vector<StoredSession> recovered;
  for (const fs::path& file : FilesIn(folder_)) {
    std::string problem;
    try {
      if (!Recover(file)) {
        continue;
      }
    } catch (const std::runtime_error& error) {  // SessionFileError or StorageError
      problem = error.what();
    }
    StoredSession session = Examine(file);
    session.problem = problem.empty() ? session.problem : problem;
    recovered.push_back(std::move(session));
  }
  return recovered;
}

}  // namespace mwidth::record
