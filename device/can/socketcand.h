// The text that a socketcand gateway speaks: elements between angle brackets, such as
// < frame 123 1700000000.424242 11223344 >.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "device/can/frame.h"

namespace mwidth::device::can {

/// Longer ones are none: the longest that a gateway sends is a frame of CAN FD, with 64 bytes in hexadecimal.
inline constexpr std::size_t kMaxElementBytes = 255;

enum class ElementKind : uint8_t {
  /// The text is too short to say: only white space is used.
  kIncomplete,
  kFrame,
  /// < hi >, the greeting.
  kHi,
  /// < ok >: what was asked for is done.
  kOk,
  /// An error of the bus, and one after which the controller has left it (bus-off).
  kErrorFrame,
  kBusOff,
  /// Frames with identifiers of 29 bits, and of CAN FD.
  kNotClassical,
  /// < error ... > with words, in answer to what was asked for.
  kRefusal,
  kMalformed,
};

struct Element {
  ElementKind kind = ElementKind::kIncomplete;
  /// How much of the text it takes, with what stands before it.
  std::size_t size = 0;
  Frame frame;
};

/// The first element of `text`, which may be any bytes. White space between elements is none; whatever else
/// stands there is malformed, and so is an element in which another one begins. Rt.
Element FirstElement(std::string_view text) noexcept;

/// The element that has the gateway send a frame.
struct SendElement {
  std::array<char, 48> text{};
  std::size_t size = 0;

  std::string_view view() const noexcept { return {text.data(), size}; }
};

/// Rt.
SendElement ToSend(const Frame& frame) noexcept;

}  // namespace mwidth::device::can
