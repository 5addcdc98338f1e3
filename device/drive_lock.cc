#include "device/drive_lock.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <stdexcept>
#include <system_error>

namespace mwidth::device {
namespace {

constexpr char kPrefix[] = "mwidth/drive/";  // NOLINT(*-avoid-c-arrays): its length is known to the compiler
static_assert(sizeof(kPrefix) + DriveLock::kLongestIdentity <= sizeof(sockaddr_un::sun_path));

}  // namespace

DriveLock::DriveLock(const std::string& identity) {
  if (identity.empty() || identity.size() > kLongestIdentity) {
    throw std::invalid_argument("the identity of a drive has " + std::to_string(identity.size()) +
                                " bytes; allowed are 1 to " + std::to_string(kLongestIdentity));
  }
  socket_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket_ < 0) {
    throw std::system_error(errno, std::generic_category(), "drive " + identity + " cannot be locked");
  }
  // An abstract name begins with a zero byte, and is as long as the address says.
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string name = kPrefix + identity;
  std::copy(name.begin(), name.end(), &address.sun_path[1]);
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  if (bind(socket_, reinterpret_cast<const sockaddr*>(&address), length) !=
      0) {  // NOLINT(*-reinterpret-cast)
    const int error = errno;
    close(socket_);
    if (error == EADDRINUSE) {
      throw std::runtime_error("drive " + identity +
                               " is held by another server on this host: end that one (ss -xap | grep "
                               "mwidth/drive shows which), or configure another drive");
    }
    throw std::system_error(error, std::generic_category(), "drive " + identity + " cannot be locked");
  }
}

DriveLock::~DriveLock() { close(socket_); }

}  // namespace mwidth::device
