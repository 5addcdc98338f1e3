#include "device/emulator/socketcan_bus.h"

#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <system_error>
#include <utility>

namespace mwidth::device::emulator {
namespace {

int OpenSocket() {
  const int file = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
  if (file < 0) {
    throw std::system_error(
        errno, std::generic_category(),
        "SocketCAN: this kernel has no CAN (modprobe can_raw), or this process may not use it; a "
        "bus of type \"socketcand\" needs neither");
  }
  return file;
}

}  // namespace

SocketcanBus::SocketcanBus(boost::asio::io_context& context, std::string interface, TakeFrame take)
    : socket_(context, OpenSocket()), interface_(std::move(interface)), take_(std::move(take)) {
  const unsigned index = if_nametoindex(interface_.c_str());
  const sockaddr_can address{.can_family = AF_CAN, .can_ifindex = static_cast<int>(index), .can_addr = {}};
  if (index == 0 || bind(socket_.native_handle(),
                         reinterpret_cast<const sockaddr*>(
                             &address),  // NOLINT(cppcoreguidelines-pro-type-reinterpret-cast)
                         sizeof address) != 0) {
    throw std::system_error(errno, std::generic_category(), "SocketCAN: " + interface_);
  }
  Read();
}

void SocketcanBus::Read() {
  socket_.async_read_some(
      boost::asio::buffer(&received_, sizeof received_), [this](auto error, std::size_t size) {
        // An interface that goes down comes up again; a socket that is closed does not.
        if (error == boost::asio::error::operation_aborted) {
          return;
        }
        constexpr canid_t kForeign = CAN_EFF_FLAG | CAN_ERR_FLAG;
        if (!error && size == sizeof received_ && (received_.can_id & kForeign) == 0 &&
            received_.can_dlc <= can::kMaxFrameBytes) {
          can::Frame frame{.identifier = static_cast<uint16_t>(received_.can_id & CAN_SFF_MASK),
                           .remote = (received_.can_id & CAN_RTR_FLAG) != 0,
                           .size = received_.can_dlc};
          std::copy_n(std::begin(received_.data), frame.size, frame.bytes.begin());
          take_(frame);
        }
        Read();
      });
}

void SocketcanBus::Send(const can::Frame& frame) {
  can_frame raw{};
  raw.can_id = frame.identifier | (frame.remote ? CAN_RTR_FLAG : 0);
  raw.can_dlc = frame.size;
  std::copy_n(frame.bytes.begin(), frame.size, std::begin(raw.data));
  // A queue that is full, or an interface that is down, loses the frame.
  [[maybe_unused]] const ssize_t ignored = write(socket_.native_handle(), &raw, sizeof raw);
}

}  // namespace mwidth::device::emulator
