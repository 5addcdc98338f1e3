// The frames of a tick: SYNC, heartbeat, the drive's TPDO1 and our RPDO1. All Rt.
#pragma once

#include <cstdint>
#include <optional>

#include "device/can/frame.h"
#include "device/canopen/little_endian.h"
#include "device/canopen/objects.h"

namespace mwidth::device::canopen {

inline can::Frame SyncFrame() noexcept { return {.identifier = kSync}; }

inline can::Frame NmtFrame(NmtCommand command, uint8_t node) noexcept {
  return {.identifier = kNmt, .size = 2, .bytes = {static_cast<uint8_t>(command), node}};
}

inline can::Frame HeartbeatFrame(uint8_t node, NmtState state) noexcept {
  return {.identifier = static_cast<uint16_t>(kHeartbeat + node),
          .size = 1,
          .bytes = {static_cast<uint8_t>(state)}};
}

/// RPDO1: 6040h, 6071h.
struct Command {
  uint16_t controlword = 0;
  int16_t torque_per_mille = 0;
};

inline can::Frame CommandFrame(uint8_t node, const Command& command) noexcept {
  can::Frame frame{.identifier = static_cast<uint16_t>(kRpdo1 + node), .size = 4};
  Put(frame, 0, 2, command.controlword);
  Put(frame, 2, 2, static_cast<uint16_t>(command.torque_per_mille));
  return frame;
}

/// TPDO1: 6041h, 6064h, 6077h.
struct Feedback {
  uint16_t statusword = 0;
  int32_t position = 0;
  int16_t torque_per_mille = 0;
};

inline constexpr uint8_t kFeedbackBytes = 8;

/// None where the frame has another length, whatever its identifier.
inline std::optional<Feedback> FeedbackOf(const can::Frame& frame) noexcept {
  if (frame.remote || frame.size != kFeedbackBytes) {
    return std::nullopt;
  }
  return Feedback{.statusword = static_cast<uint16_t>(Get(frame, 0, 2)),
                  .position = static_cast<int32_t>(Get(frame, 2, 4)),
                  .torque_per_mille = static_cast<int16_t>(Get(frame, 6, 2))};
}

}  // namespace mwidth::device::canopen
