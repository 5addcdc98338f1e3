#include "device/emulator/modbus_rtu.h"

namespace mwidth::device::emulator {
namespace {

constexpr std::size_t kUnitBytes = 1;
constexpr std::size_t kChecksumBytes = 2;

// The whole length of a request that counts its own data in the byte at `place`.
std::optional<std::size_t> Counted(std::span<const uint8_t> bytes, std::size_t place) {
  if (bytes.size() <= place) {
    return std::nullopt;
  }
  return place + 1 + bytes[place] + kChecksumBytes;
}

}  // namespace

uint16_t RtuChecksum(std::span<const uint8_t> bytes) {
  constexpr uint16_t kPolynomial = 0xA001;
  uint16_t crc = 0xFFFF;
  for (const uint8_t byte : bytes) {
    crc = static_cast<uint16_t>(crc ^ byte);
    for (int bit = 0; bit < 8; ++bit) {
      crc = static_cast<uint16_t>((crc & 1) != 0 ? (crc >> 1) ^ kPolynomial : crc >> 1);
    }
  }
  return crc;
}

std::optional<std::size_t> RtuRequestBytes(std::span<const uint8_t> bytes) {
  if (bytes.size() <= kUnitBytes) {
    return std::nullopt;
  }
  constexpr std::size_t kFixed = 8;
  switch (bytes[kUnitBytes]) {
    // Reads, and writes of one coil or register: two words.
    case 1:
    case 2:
    case 3:
    case 4:
    case 5:
    case 6:
      return kFixed;
    // Writes of many: address, count, bytes.
    case 15:
    case 16:
      return Counted(bytes, 6);
    // Read and write: twice address and count, bytes.
    case 23:
      return Counted(bytes, 10);
    default:
      return std::nullopt;
  }
}

bool IsWholeRtuFrame(std::span<const uint8_t> frame) {
  if (frame.size() < kUnitBytes + 1 + kChecksumBytes || frame.size() > kMaxRtuBytes) {
    return false;
  }
  const auto checksum = frame.last(kChecksumBytes);
  return (checksum[0] | checksum[1] << 8) == RtuChecksum(frame.first(frame.size() - kChecksumBytes));
}

std::vector<uint8_t> RtuFrame(uint8_t unit, std::span<const uint8_t> pdu) {
  std::vector<uint8_t> frame;
  frame.reserve(kUnitBytes + pdu.size() + kChecksumBytes);
  frame.push_back(unit);
  frame.insert(frame.end(), pdu.begin(), pdu.end());
  const uint16_t crc = RtuChecksum(frame);
  frame.push_back(static_cast<uint8_t>(crc & 0xFF));
  frame.push_back(static_cast<uint8_t>(crc >> 8));
  return frame;
}

}  // namespace mwidth::device::emulator
