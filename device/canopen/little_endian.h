// Numbers in frames: CANopen sends the least byte first (CiA 301, 7.1.4.2).
#pragma once

#include <cstddef>
#include <cstdint>

#include "device/can/frame.h"

namespace mwidth::device::canopen {

/// The `size` bytes of the frame from `at`, as a number; both within the frame's eight bytes. Rt.
inline uint32_t Get(const can::Frame& frame, std::size_t at, std::size_t size) noexcept {
  uint32_t value = 0;
  for (std::size_t i = 0; i < size; ++i) {
    value |= static_cast<uint32_t>(frame.bytes[at + i]) << (8 * i);
  }
  return value;
}

/// Writes the least `size` bytes of `value` from `at`. Rt.
inline void Put(can::Frame& frame, std::size_t at, std::size_t size, uint32_t value) noexcept {
  for (std::size_t i = 0; i < size; ++i) {
    frame.bytes[at + i] = static_cast<uint8_t>(value >> (8 * i));
  }
}

}  // namespace mwidth::device::canopen
