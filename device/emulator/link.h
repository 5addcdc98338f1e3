// The link that an emulated drive is reached by.
#pragma once

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "device/canopen/canopen_drive_config.h"
#include "device/emulator/faults.h"
#include "device/emulator/joint.h"
#include "device/modbus/modbus_drive_config.h"

namespace mwidth::device::emulator {

/// This end of the link, where it is not what the configuration says of the other one.
struct LinkPlace {
  /// Of a listening socket.
  std::string address = "127.0.0.1";
  /// 0: any free one. For a CANopen drive it asks for a gateway, whichever bus the configuration names.
  std::optional<uint16_t> port;
  /// Serial port; empty: the configuration's. It asks for RTU, whichever Modbus the configuration names.
  std::string device;
  /// A pseudo-terminal instead of a serial port.
  bool pty = false;
};

/// Serves until it is destroyed, while its io_context runs in one thread.
class Link {
 public:
  Link() = default;
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;
  virtual ~Link() = default;

  /// What the other end opens or connects to.
  virtual std::string Where() const = 0;
  /// Whether it can have the fault that a command (commands.h) asks for.
  virtual bool Has(std::string_view fault) const = 0;
  /// Lets time pass. To be called every millisecond.
  virtual void Turn(int64_t /*now_ns*/) {}
  /// An error of the drive's own, where Has("emcy").
  virtual void Fail(uint16_t /*code*/) {}
};

/// Said where a LinkPlace has a serial port for another link.
inline constexpr const char* kSerialOnly = "--pty and --device are for Modbus drives";

/// Opens the link of a configuration. References outlive it. Throws std::invalid_argument
/// where `place` is for another link, std::system_error or boost::system::system_error where it cannot be
/// opened.
std::unique_ptr<Link> OpenLink(boost::asio::io_context& context, const modbus::ModbusDriveConfig& drive,
                               const LinkPlace& place, Joint& joint, const LinkFaults& faults);
/// `has_watchdog`: whether the drive can watch its master's heartbeat.
std::unique_ptr<Link> OpenLink(boost::asio::io_context& context, const canopen::CanopenDriveConfig& drive,
                               const LinkPlace& place, bool has_watchdog, Joint& joint,
                               const LinkFaults& faults);

}  // namespace mwidth::device::emulator
