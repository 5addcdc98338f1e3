// Tells whether the server that writes a session lives.
#pragma once

#include <filesystem>
#include <optional>

namespace mwidth::record {

/// Held by the server that writes a session: an flock(2) on a file beside it, which the kernel gives back
/// when the process ends, however it ends. (Not on the session's own file: closing any descriptor of that
/// would undo the locks that SQLite has on it in this process.)
class SessionLock {
 public:
  /// Takes the lock of the session `file`. Nothing where another holds it, or where the lock's file cannot be
  /// made; errno tells which (EWOULDBLOCK: held).
  static std::optional<SessionLock> Take(const std::filesystem::path& file);
  /// True where somebody holds it: another process, or this one.
  static bool Held(const std::filesystem::path& file);

  SessionLock(SessionLock&& other) noexcept;
  SessionLock& operator=(SessionLock&&) = delete;
  /// Gives it back and removes its file.
  ~SessionLock();

 private:
  SessionLock(std::filesystem::path file, int descriptor);

  std::filesystem::path file_;
  int descriptor_;
};

}  // namespace mwidth::record
