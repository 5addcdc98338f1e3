// Modbus TCP in front of an emulated drive.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <cstdint>
#include <string>

#include "device/emulator/faults.h"
#include "device/emulator/modbus_registers.h"

namespace mwidth::device::emulator {

/// Any number of connections, one request after the other on each. Lives on one io_context with one thread.
class ModbusTcpServer {
 public:
  /// Listens on `address` and `port` (0: any free one). All references outlive it. Throws std::system_error.
  ModbusTcpServer(boost::asio::io_context& context, const std::string& address, uint16_t port, uint8_t unit,
                  ModbusRegisters& registers, const LinkFaults& faults);

  uint16_t port() const { return acceptor_.local_endpoint().port(); }

 private:
  void Accept();

  boost::asio::ip::tcp::acceptor acceptor_;
  const uint8_t unit_;
  ModbusRegisters& registers_;
  const LinkFaults& faults_;
};

}  // namespace mwidth::device::emulator
