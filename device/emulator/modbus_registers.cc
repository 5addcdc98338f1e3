#include "device/emulator/modbus_registers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

namespace mwidth::device::emulator {
namespace {

using modbus::Decode;
using modbus::Encode;
using modbus::RegisterValue;
using Bytes = std::vector<uint8_t>;

constexpr uint8_t kReadHoldingRegisters = 3;
constexpr uint8_t kWriteSingleRegister = 6;
constexpr uint8_t kWriteMultipleRegisters = 16;
constexpr uint8_t kReadWriteMultipleRegisters = 23;
constexpr uint8_t kIllegalFunction = 1;
constexpr uint8_t kIllegalAddress = 2;
constexpr uint8_t kIllegalValue = 3;
constexpr uint8_t kDeviceFailure = 4;

Bytes Exception(uint8_t function, uint8_t code) { return {static_cast<uint8_t>(function | 0x80), code}; }

uint16_t Word(std::span<const uint8_t> bytes, std::size_t at) {
  return static_cast<uint16_t>(bytes[at] << 8 | bytes[at + 1]);
}

// Where in the registers of `value` an address lies; beyond them where it does not.
std::size_t PlaceIn(const RegisterValue& value, uint16_t address) {
  return static_cast<uint16_t>(address - value.address);
}

}  // namespace

ModbusRegisters::ModbusRegisters(modbus::ModbusDriveConfig config, Joint& joint, const LinkFaults& faults)
    : config_(std::move(config)), joint_(joint), faults_(faults) {}

std::array<uint16_t, modbus::kMaxValueRegisters> ModbusRegisters::Coded(const RegisterValue& value,
                                                                        double quantity) const {
  auto words = Encode(value, (quantity - value.offset) / value.scale);
  if (faults_.wrong_order && value.Registers() == 2) {
    std::swap(words[0], words[1]);
  }
  return words;
}

bool ModbusRegisters::ReadWord(uint16_t address, int64_t now_ns, uint16_t& word) {
  const modbus::DriveMap& map = config_.map;
  if (const std::size_t place = PlaceIn(map.position, address); place < map.position.Registers()) {
    const double position = static_cast<double>(joint_.PositionCounts(now_ns)) * config_.position_quantum;
    word = Coded(map.position, position).at(place);
  } else if (const std::size_t at = PlaceIn(map.force, address); at < map.force.Registers()) {
    word = Coded(map.force, joint_.force_counts() * config_.force_quantum).at(at);
  } else if (map.enable && address == map.enable->address) {
    word = joint_.enabled() ? map.enable->enabled : map.enable->disabled;
  } else if (map.watchdog && PlaceIn(map.watchdog->timeout, address) < map.watchdog->timeout.Registers()) {
    word = Coded(map.watchdog->timeout, joint_.watchdog_s()).at(PlaceIn(map.watchdog->timeout, address));
  } else if (map.watchdog && address == map.watchdog->reaction) {
    const auto disables = static_cast<uint16_t>(map.watchdog->no_reaction + kDisables);
    word = joint_.watchdog_s() > 0 ? disables : map.watchdog->no_reaction;
  } else {
    return false;
  }
  return true;
}

// Only whole values: half of a force would be one that nobody asked for.
uint8_t ModbusRegisters::WriteWords(uint16_t address, std::span<const uint8_t> bytes, int64_t now_ns) {
  const modbus::DriveMap& map = config_.map;
  if (address == map.force.address && bytes.size() == 2 * map.force.Registers()) {
    std::array<uint16_t, modbus::kMaxValueRegisters> words{};
    for (std::size_t i = 0; i < map.force.Registers(); ++i) {
      words.at(i) = Word(bytes, 2 * i);
    }
    const double force = Decode(map.force, words) * map.force.scale + map.force.offset;
    const double counts = std::round(force / config_.force_quantum);
    // Not so for what is no number.
    if (!(std::abs(counts) <= std::numeric_limits<int32_t>::max())) {
      return kIllegalValue;
    }
    if (!map.enable) {
      joint_.SetEnabled(now_ns, true);
    }
    joint_.SetForce(now_ns, static_cast<int32_t>(counts));
    return 0;
  }
  if (map.enable && address == map.enable->address && bytes.size() == 2) {
    joint_.SetEnabled(now_ns, Word(bytes, 0) == map.enable->enabled);
    return 0;
  }
  return kIllegalAddress;
}

Bytes ModbusRegisters::Read(std::span<const uint8_t> request, int64_t now_ns) {
  constexpr std::size_t kMost = 125;
  const uint16_t address = Word(request, 1);
  const uint16_t count = Word(request, 3);
  if (count == 0 || count > kMost) {
    return Exception(request[0], kIllegalValue);
  }
  Bytes answer{request[0], static_cast<uint8_t>(2 * count)};
  for (uint16_t i = 0; i < count; ++i) {
    uint16_t word = 0;
    if (!ReadWord(static_cast<uint16_t>(address + i), now_ns, word)) {
      return Exception(request[0], kIllegalAddress);
    }
    answer.push_back(static_cast<uint8_t>(word >> 8));
    answer.push_back(static_cast<uint8_t>(word & 0xFF));
  }
  return answer;
}

Bytes ModbusRegisters::WriteOne(std::span<const uint8_t> request, int64_t now_ns) {
  const uint8_t refusal = WriteWords(Word(request, 1), request.subspan(3, 2), now_ns);
  return refusal == 0 ? Bytes(request.begin(), request.end()) : Exception(request[0], refusal);
}

Bytes ModbusRegisters::WriteMany(std::span<const uint8_t> request, int64_t now_ns) {
  constexpr std::size_t kHeader = 6;
  if (request.size() < kHeader || request[5] != request.size() - kHeader ||
      Word(request, 3) * 2 != request[5]) {
    return Exception(request[0], kIllegalValue);
  }
  const uint8_t refusal = WriteWords(Word(request, 1), request.subspan(kHeader), now_ns);
  return refusal == 0 ? Bytes(request.begin(), request.begin() + 5) : Exception(request[0], refusal);
}

Bytes ModbusRegisters::ReadWrite(std::span<const uint8_t> request, int64_t now_ns) {
  constexpr std::size_t kHeader = 10;
  if (request.size() < kHeader || request[9] != request.size() - kHeader ||
      Word(request, 7) * 2 != request[9]) {
    return Exception(request[0], kIllegalValue);
  }
  const uint8_t refusal = WriteWords(Word(request, 5), request.subspan(kHeader), now_ns);
  return refusal == 0 ? Read(request, now_ns) : Exception(request[0], refusal);
}

Bytes ModbusRegisters::Answer(std::span<const uint8_t> request, int64_t now_ns) {
  constexpr std::size_t kLeastBytes = 5;
  joint_.Feed(now_ns);
  if (request.empty() || faults_.silent) {
    return {};
  }
  if (faults_.exceptions) {
    return Exception(request[0], kDeviceFailure);
  }
  constexpr std::array kKnown{kReadHoldingRegisters, kWriteSingleRegister, kWriteMultipleRegisters,
                              kReadWriteMultipleRegisters};
  if (std::find(kKnown.begin(), kKnown.end(), request[0]) == kKnown.end()) {
    return Exception(request[0], kIllegalFunction);
  }
  if (request.size() < kLeastBytes) {
    return Exception(request[0], kIllegalValue);
  }
  switch (request[0]) {
    case kReadHoldingRegisters:
      return Read(request, now_ns);
    case kWriteSingleRegister:
      return WriteOne(request.first(kLeastBytes), now_ns);
    case kWriteMultipleRegisters:
      return WriteMany(request, now_ns);
    default:
      return ReadWrite(request, now_ns);
  }
}

}  // namespace mwidth::device::emulator
