// All that is heard on the bus of one drive, sorted.
#pragma once

#include <cstdint>
#include <optional>

#include "device/can/frame.h"
#include "device/canopen/frames.h"
#include "device/canopen/objects.h"

namespace mwidth::device::canopen {

/// What of a frame somebody waits for.
enum class Heard : uint8_t {
  kFeedback,
  kSdoAnswer,
  /// Nobody: it is noted, or passed over.
  kNoted,
};

struct NodeCounters {
  uint64_t foreign = 0;
  /// Of the drive, but of a length that they cannot have.
  uint64_t malformed = 0;
  uint64_t emergencies = 0;
  /// Positions that nobody asked for any more, or that came twice.
  uint64_t late_positions = 0;
};

/// Remembers what the drive last said. One thread at a time; all Rt.
class NodeWatch {
 public:
  NodeWatch(uint8_t node, uint8_t own_node) noexcept : node_(node), own_node_(own_node) {}

  /// Takes one frame that came at `now_ns`; any bytes.
  Heard Hear(const can::Frame& frame, int64_t now_ns) noexcept;
  /// From now on the drive is operational, and what it said before does not count.
  void Begin(int64_t now_ns) noexcept;

  const Feedback& feedback() const noexcept { return feedback_; }
  /// True while its heartbeats say that it does what it was set up for.
  bool operational() const noexcept { return operational_; }
  int64_t heartbeat_ns() const noexcept { return heartbeat_ns_; }
  /// Error code of the newest emergency; 0 where it is over.
  uint16_t emergency_code() const noexcept { return emergency_code_; }
  void ForgetEmergency() noexcept { emergency_code_ = 0; }
  /// The newest foreign frame: when, and its identifier; none since Begin.
  std::optional<int64_t> foreign_ns() const noexcept { return foreign_ns_; }
  uint16_t foreign_identifier() const noexcept { return foreign_identifier_; }

  NodeCounters counters;

 private:
  bool IsForeign(const can::Frame& frame) const noexcept;
  Heard HearEmergency(const can::Frame& frame) noexcept;
  Heard HearHeartbeat(const can::Frame& frame, int64_t now_ns) noexcept;
  Heard Malformed() noexcept;

  const uint8_t node_;
  const uint8_t own_node_;
  Feedback feedback_;
  bool operational_ = false;
  int64_t heartbeat_ns_ = 0;
  uint16_t emergency_code_ = 0;
  std::optional<int64_t> foreign_ns_;
  uint16_t foreign_identifier_ = 0;
};

}  // namespace mwidth::device::canopen
