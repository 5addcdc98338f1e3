// The bytes of Modbus RTU (Modbus over Serial Line, Specification and Implementation Guide V1.02).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace mwidth::device::emulator {

/// The longest frame: unit, 253 bytes, checksum.
inline constexpr std::size_t kMaxRtuBytes = 256;

/// CRC-16 with the polynomial x^16 + x^15 + x^2 + 1, reflected, from FFFFh (section 2.5.1.2); sent low byte
/// first.
uint16_t RtuChecksum(std::span<const uint8_t> bytes);

/// How long the request that begins here is, checksum included, as its function says; none where that cannot
/// be told yet, or ever. At most kMaxRtuBytes + 12.
std::optional<std::size_t> RtuRequestBytes(std::span<const uint8_t> bytes);

/// Whether the checksum at the end of a frame is right.
bool IsWholeRtuFrame(std::span<const uint8_t> frame);

/// Unit, protocol data unit and checksum.
std::vector<uint8_t> RtuFrame(uint8_t unit, std::span<const uint8_t> pdu);

}  // namespace mwidth::device::emulator
