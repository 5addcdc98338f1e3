#include "server/record/session/session_lock.h"

#include <cerrno>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace mwidth::record {
namespace {

std::filesystem::path LockOf(const std::filesystem::path& file) { return file.string() + ".lock"; }

// True where the open file is the one of that name.
bool IsAt(const std::filesystem::path& name, int descriptor) {
  struct stat open_file {};
  struct stat named {};
  return fstat(descriptor, &open_file) == 0 && stat(name.c_str(), &named) == 0 &&
         open_file.st_dev == named.st_dev && open_file.st_ino == named.st_ino;
}

}  // namespace

SessionLock::SessionLock(std::filesystem::path file, int descriptor)
    : file_(std::move(file)), descriptor_(descriptor) {}

SessionLock::SessionLock(SessionLock&& other) noexcept
    : file_(std::move(other.file_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

SessionLock::~SessionLock() {
  if (descriptor_ >= 0) {
    unlink(file_.c_str());  // while it is held, so that nobody can have taken it
    close(descriptor_);
  }
}

std::optional<SessionLock> SessionLock::Take(const std::filesystem::path& file) {
  const std::filesystem::path lock = LockOf(file);
  while (true) {
    const int descriptor = open(lock.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0640);
    if (descriptor < 0) {
      return std::nullopt;
    }
    if (flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
      const int reason = errno;
      close(descriptor);
      errno = reason;
      return std::nullopt;
    }
    if (IsAt(lock, descriptor)) {
      return SessionLock(lock, descriptor);
    }
    close(descriptor);  // opened before its last holder removed it: a lock that nobody else would find
  }
}

bool SessionLock::Held(const std::filesystem::path& file) {
  const int descriptor = open(LockOf(file).c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) {
    return false;
  }
  const bool held = flock(descriptor, LOCK_SH | LOCK_NB) != 0;
  close(descriptor);
  return held;
}

}  // namespace mwidth::record
