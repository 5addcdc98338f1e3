// The drive's end of a serial line: a port, or a pseudo-terminal made for the purpose.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/serial_port.hpp>
#include <chrono>
#include <string>

#include "device/modbus/modbus_drive_config.h"

namespace mwidth::device::emulator {

/// Opens a port with the line's speed and parity. Throws boost::system::system_error.
boost::asio::serial_port OpenSerialPort(boost::asio::io_context& context, const std::string& device,
                                        const modbus::SerialLine& line);

/// A line that has no wire.
class PseudoTerminal {
 public:
  /// Throws std::system_error.
  explicit PseudoTerminal(boost::asio::io_context& context);
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;
  ~PseudoTerminal();

  /// What the other end opens.
  const std::string& path() const { return path_; }
  /// Once.
  boost::asio::serial_port TakeLine() { return std::move(line_); }

 private:
  boost::asio::serial_port line_;
  std::string path_;
  /// The other end held open, so that the line stays when nobody else has it.
  int other_end_ = -1;
};

/// The silence that ends a frame: 3.5 characters of 11 bits, and above 19200 baud 1.75 ms (Modbus over Serial
/// Line V1.02, section 2.5.1.1).
std::chrono::microseconds RtuSilence(int baud);

}  // namespace mwidth::device::emulator
