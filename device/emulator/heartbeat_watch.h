// A heartbeat consumer of CANopen (CiA 301, sections 7.2.8.2.2.1 and 7.5.2.19: object 1016h).
#pragma once

#include <cstdint>
#include <optional>

#include "device/emulator/object_dictionary.h"

namespace mwidth::device::emulator {

/// Watches one other node, from its first heartbeat on. Lives in one thread.
class HeartbeatWatch {
 public:
  /// Adds its object to `objects`, which outlives it.
  explicit HeartbeatWatch(ObjectDictionary& objects);

  /// True where it is the node that is watched.
  bool Hear(uint8_t node, int64_t now_ns);
  /// When the heartbeat was missed, where that is not later than `now_ns`; once.
  std::optional<int64_t> Missed(int64_t now_ns);
  /// Waits for a first heartbeat again.
  void Reset() { heard_ns_.reset(); }

  /// How long the other node may be silent, s.
  double patience_s() const;

 private:
  ObjectDictionary& objects_;
  std::optional<int64_t> heard_ns_;
};

}  // namespace mwidth::device::emulator
