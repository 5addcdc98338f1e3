#include "device/canopen/node_watch.h"

#include <algorithm>
#include <array>

#include "device/canopen/little_endian.h"

namespace mwidth::device::canopen {
namespace {

constexpr uint8_t kEmergencyBytes = 8;
constexpr uint8_t kHeartbeatBytes = 1;
// NMT commands for every node.
constexpr uint8_t kAllNodes = 0;

}  // namespace

void NodeWatch::Begin(int64_t now_ns) noexcept {
  operational_ = true;
  heartbeat_ns_ = now_ns;
  feedback_ = {};
  emergency_code_ = 0;
  foreign_ns_.reset();
}

bool NodeWatch::IsForeign(const can::Frame& frame) const noexcept {
  if (frame.remote) {
    return false;  // It asks, and commands nothing.
  }
  if (frame.identifier == kNmt) {
    return frame.size == 2 && (frame.bytes[1] == node_ || frame.bytes[1] == kAllNodes);
  }
  if (frame.identifier == kSync || frame.identifier == kHeartbeat + own_node_) {
    return true;
  }
  constexpr std::array kToTheDrive{kRpdo1, kRpdo2, kRpdo3, kRpdo4, kSdoRequest};
  return std::any_of(kToTheDrive.begin(), kToTheDrive.end(),
                     [&](uint16_t base) { return frame.identifier == base + node_; });
}

Heard NodeWatch::Malformed() noexcept {
  ++counters.malformed;
  return Heard::kNoted;
}

Heard NodeWatch::Hear(const can::Frame& frame, int64_t now_ns) noexcept {
  if (IsForeign(frame)) {
    ++counters.foreign;
    foreign_ns_ = now_ns;
    foreign_identifier_ = frame.identifier;
    return Heard::kNoted;
  }
  if (frame.remote) {
    return Heard::kNoted;
  }
  if (frame.identifier == kTpdo1 + node_) {
    const std::optional<Feedback> feedback = FeedbackOf(frame);
    feedback_ = feedback.value_or(feedback_);
    return feedback ? Heard::kFeedback : Malformed();
  }
  if (frame.identifier == kSdoReply + node_) {
    return frame.size == can::kMaxFrameBytes ? Heard::kSdoAnswer : Malformed();
  }
  if (frame.identifier == kEmergency + node_) {
    return HearEmergency(frame);
  }
  return frame.identifier == kHeartbeat + node_ ? HearHeartbeat(frame, now_ns) : Heard::kNoted;
}

Heard NodeWatch::HearEmergency(const can::Frame& frame) noexcept {
  if (frame.size != kEmergencyBytes) {
    return Malformed();
  }
  emergency_code_ = static_cast<uint16_t>(Get(frame, 0, 2));
  ++counters.emergencies;
  return Heard::kNoted;
}

Heard NodeWatch::HearHeartbeat(const can::Frame& frame, int64_t now_ns) noexcept {
  if (frame.size != kHeartbeatBytes) {
    return Malformed();
  }
  heartbeat_ns_ = now_ns;
  // Latched until Begin: a drive that has booted anew has forgotten what it was told.
  operational_ = operational_ && frame.bytes[0] == static_cast<uint8_t>(NmtState::kOperational);
  return Heard::kNoted;
}

}  // namespace mwidth::device::canopen
