// Which CAN bus to speak on, and the way to it.
#pragma once

#include <cstdint>
#include <string>
#include <variant>

namespace mwidth::device::can {

/// A controller of this host, by the kernel's SocketCAN.
struct SocketCan {
  /// As `ip link` names it: can0.
  std::string interface;
};

/// A controller of another host, by the socketcand protocol over TCP.
struct Socketcand {
  /// Name or address, IPv4 or IPv6.
  std::string host;
  uint16_t port = 29'536;
  /// As the gateway names it.
  std::string interface;
};

using BusConfig = std::variant<SocketCan, Socketcand>;

}  // namespace mwidth::device::can
