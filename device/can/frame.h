// A frame of classical CAN (ISO 11898-1) with an identifier of 11 bits, as CANopen uses them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace mwidth::device::can {

inline constexpr uint16_t kMaxIdentifier = 0x7FF;
inline constexpr std::size_t kMaxFrameBytes = 8;

struct Frame {
  /// 0 to kMaxIdentifier.
  uint16_t identifier = 0;
  /// A remote frame asks for data and carries none.
  bool remote = false;
  /// Bytes of `bytes` that count, 0 to kMaxFrameBytes; those behind are 0.
  uint8_t size = 0;
  std::array<uint8_t, kMaxFrameBytes> bytes{};

  std::span<const uint8_t> data() const noexcept { return {bytes.data(), size}; }
  bool operator==(const Frame&) const = default;
};

}  // namespace mwidth::device::can
