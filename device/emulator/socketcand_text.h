// The text of the socketcand protocol, from the gateway's side (socketcand, doc/protocol.md).
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "device/can/frame.h"

namespace mwidth::device::emulator {

/// Longest element that a client may send.
inline constexpr std::size_t kMaxElementBytes = 256;

enum class GatewayWord : uint8_t { kUnknown, kOpen, kRawMode, kBcmMode, kEcho, kSend };

/// What one element, "< word ... >", says.
struct GatewayCommand {
  GatewayWord word = GatewayWord::kUnknown;
  /// kOpen.
  std::string bus;
  /// kSend. Only identifiers of 11 bits; others are kUnknown.
  can::Frame frame;
};

/// Takes the first element, with its < and >, and what stands before it, off the front of `text`; none while
/// there is no whole one.
std::optional<std::string> TakeElement(std::string& text);

/// Any text.
GatewayCommand ParseElement(std::string_view element);

/// How a client is told of a frame.
std::string FrameElement(const can::Frame& frame, std::chrono::microseconds since_epoch);

}  // namespace mwidth::device::emulator
