// The holding registers of an emulated drive.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "device/emulator/faults.h"
#include "device/emulator/joint.h"
#include "device/modbus/modbus_drive_config.h"

namespace mwidth::device::emulator {

/// Answers requests to the registers of a map: functions 3, 6, 16 and 23 (Modbus Application Protocol
/// Specification V1.1b3). What the map does not name does not exist. Any thread.
class ModbusRegisters {
 public:
  /// Reaction that the drive reports of its watchdog.
  static constexpr uint16_t kDisables = 1;

  /// `joint` and `faults` outlive it.
  ModbusRegisters(modbus::ModbusDriveConfig config, Joint& joint, const LinkFaults& faults);

  /// The protocol data unit of the answer to `request`, of any bytes and length; empty where there is none.
  std::vector<uint8_t> Answer(std::span<const uint8_t> request, int64_t now_ns);

 private:
  using Bytes = std::vector<uint8_t>;

  bool ReadWord(uint16_t address, int64_t now_ns, uint16_t& word);
  /// The code of the exception; 0 where the value was taken.
  uint8_t WriteWords(uint16_t address, std::span<const uint8_t> bytes, int64_t now_ns);
  Bytes Read(std::span<const uint8_t> request, int64_t now_ns);
  Bytes WriteOne(std::span<const uint8_t> request, int64_t now_ns);
  Bytes WriteMany(std::span<const uint8_t> request, int64_t now_ns);
  Bytes ReadWrite(std::span<const uint8_t> request, int64_t now_ns);
  std::array<uint16_t, modbus::kMaxValueRegisters> Coded(const modbus::RegisterValue& value,
                                                         double quantity) const;

  const modbus::ModbusDriveConfig config_;
  Joint& joint_;
  const LinkFaults& faults_;
};

}  // namespace mwidth::device::emulator
