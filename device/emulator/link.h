// The link that an emulated drive is reached by.
#pragma once

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <memory>
#include <string>

#include "device/emulator/faults.h"
#include "device/emulator/joint.h"
#include "device/modbus/modbus_drive_config.h"

namespace mwidth::device::emulator {

/// This end of the link, where it is not what the configuration says of the other one.
struct LinkPlace {
  /// Of a listening socket; port 0: any free one.
  std::string address = "127.0.0.1";
  uint16_t port = 0;
  /// Serial port; empty: the configuration's.
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
};

/// Opens the link of a configuration. References outlive it. Throws std::invalid_argument
/// where `place` is for another link, std::system_error or boost::system::system_error where it cannot be
/// opened.
std::unique_ptr<Link> OpenLink(boost::asio::io_context& context, const modbus::ModbusDriveConfig& drive,
                               const LinkPlace& place, Joint& joint, const LinkFaults& faults);

}  // namespace mwidth::device::emulator
