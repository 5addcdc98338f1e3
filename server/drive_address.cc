#include "server/drive_address.h"

#include <charconv>
#include <cstdint>
#include <optional>
#include <utility>
#include <variant>

namespace mwidth::server {
namespace {

namespace can = device::can;
namespace modbus = device::modbus;

struct HostAndPort {
  std::string host;
  uint16_t port = 0;
};

// An IPv6 address stands in brackets before its port.
std::optional<HostAndPort> ParseHostAndPort(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  if (colon == std::string::npos) {
    return std::nullopt;
  }
  HostAndPort parsed{.host = address.substr(0, colon)};
  if (parsed.host.size() > 2 && parsed.host.front() == '[' && parsed.host.back() == ']') {
    parsed.host = parsed.host.substr(1, parsed.host.size() - 2);
  }
  const char* end = address.data() + address.size();
  const auto [read_to, error] = std::from_chars(address.data() + colon + 1, end, parsed.port);
  const bool whole = error == std::errc() && read_to == end;
  return whole && parsed.port > 0 && !parsed.host.empty() ? std::optional(std::move(parsed)) : std::nullopt;
}

[[noreturn]] void Refuse(const AxisConfig& axis, const std::string& problem) {
  throw ConfigError("the drive's address: axis " + axis.name + " " + problem);
}

void Place(const std::string& address, const AxisConfig& axis, modbus::LinkConfig& link) {
  if (address.starts_with('/')) {
    const auto* configured = std::get_if<modbus::SerialLine>(&link.peer);
    modbus::SerialLine line = configured != nullptr ? *configured : modbus::SerialLine{};
    line.device = address;
    link.peer = std::move(line);
  } else if (auto tcp = ParseHostAndPort(address)) {
    link.peer = modbus::TcpAddress{.host = std::move(tcp->host), .port = tcp->port};
  } else {
    Refuse(axis, "has a Modbus drive; give HOST:PORT or the path of a serial device");
  }
}

void Place(const std::string& address, const AxisConfig& axis, can::BusConfig& bus) {
  if (auto gateway = ParseHostAndPort(address)) {
    std::string interface = std::visit([](const auto& configured) { return configured.interface; }, bus);
    bus = can::Socketcand{
        .host = std::move(gateway->host), .port = gateway->port, .interface = std::move(interface)};
  } else if (!address.empty() && address.find_first_of(":/ ") == std::string::npos) {
    bus = can::SocketCan{.interface = address};
  } else {
    Refuse(axis, "has a CANopen drive; give a CAN interface, or HOST:PORT of a socketcand gateway");
  }
}

}  // namespace

void PlaceDrive(const std::string& address, AxisConfig& axis) {
  auto& behind = axis.drive.behind;
  if (auto* modbus = std::get_if<modbus::ModbusDriveConfig>(&behind)) {
    Place(address, axis, modbus->link);
  } else if (auto* canopen = std::get_if<device::canopen::CanopenDriveConfig>(&behind)) {
    Place(address, axis, canopen->bus);
  } else {
    Refuse(axis, "has a simulated drive, which is nowhere");
  }
}

}  // namespace mwidth::server
