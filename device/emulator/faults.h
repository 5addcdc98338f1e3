// What an emulated drive does wrong on demand.
#pragma once

#include <atomic>
#include <cstdint>

namespace mwidth::device::emulator {

/// Faults of the link. Set by the thread that reads commands, read by those that answer.
struct LinkFaults {
  /// No request is answered.
  std::atomic<bool> silent{false};
  /// Every request is refused: an exception of Modbus (slave device failure), an abort of an SDO.
  std::atomic<bool> exceptions{false};
  /// Numbers of 32 bits come with their registers exchanged.
  std::atomic<bool> wrong_order{false};
  /// Answers wait this long.
  std::atomic<int64_t> delay_ns{0};
  /// Answers come byte by byte, this far apart; 0: at once.
  std::atomic<int64_t> dribble_ns{0};
  /// A CANopen node sends no heartbeats.
  std::atomic<bool> heartbeat_lost{false};
};

}  // namespace mwidth::device::emulator
