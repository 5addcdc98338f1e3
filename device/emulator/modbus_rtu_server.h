// Modbus RTU in front of an emulated drive.
#pragma once

#include <array>
#include <boost/asio/serial_port.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "device/emulator/answer_writer.h"
#include "device/emulator/faults.h"
#include "device/emulator/modbus_registers.h"
#include "device/emulator/modbus_rtu.h"

namespace mwidth::device::emulator {

/// One unit on a line. A request ends where its function says; what the checksum rejects, and what no
/// function measures, ends with the next silence. Lives on one io_context with one thread.
class ModbusRtuServer {
 public:
  /// `line` is open; `silence` ends a frame. References outlive it.
  ModbusRtuServer(boost::asio::serial_port line, uint8_t unit, std::chrono::microseconds silence,
                  ModbusRegisters& registers, const LinkFaults& faults);

 private:
  void Read();
  void Next();
  void AwaitSilence();
  void EndFrame();
  /// Does what a whole frame asks.
  void Obey(std::span<const uint8_t> frame);

  boost::asio::serial_port line_;
  AnswerWriter<boost::asio::serial_port> writer_;
  boost::asio::steady_timer silence_timer_;
  const uint8_t unit_;
  const std::chrono::microseconds silence_;
  ModbusRegisters& registers_;
  std::array<uint8_t, kMaxRtuBytes> part_{};
  std::vector<uint8_t> received_;
  bool answering_ = false;
};

}  // namespace mwidth::device::emulator
