// One process for one drive.
#pragma once

#include <string>

namespace mwidth::device {

/// Holds a drive for this process, on this host, as long as it lives: two servers that command the same motor
/// would each undo what the other does, and neither could vouch for the sum. Every drive with a motor has one
/// as its first member, so that the second server is refused before it touches the link. A simulated drive
/// has none.
///
/// The lock is a name in the kernel's abstract socket namespace. The kernel takes it back when the process
/// ends, however it ends: nothing stale is left, and no file that another user's server might not open. It
/// reaches as far as the network namespace: two containers with networks of their own do not see each other.
class DriveLock {
 public:
  /// `identity` names the physical drive, the same from every server: link and address, such as
  /// "modbus:/dev/ttyUSB0"; 1 to kLongestIdentity bytes. Throws std::invalid_argument for another one, and
  /// std::runtime_error, with what to do, where the drive is held already.
  explicit DriveLock(const std::string& identity);
  DriveLock(const DriveLock&) = delete;
  DriveLock& operator=(const DriveLock&) = delete;
  ~DriveLock();

  /// What the kernel's names have room for, besides the prefix.
  static constexpr std::size_t kLongestIdentity = 90;

 private:
  int socket_ = -1;
};

}  // namespace mwidth::device
