// What goes over the bus in a tick: our heartbeat, SYNC, the drive's position, our command.
#pragma once

#include <cstdint>
#include <optional>

#include "device/can/bus.h"
#include "device/canopen/canopen_drive_config.h"
#include "device/canopen/node_watch.h"
#include "device/canopen/sdo_client.h"

namespace mwidth::device::canopen {

/// PDOs bear no number, so each SYNC is answered before there is another one: a position that comes too late
/// for its tick is counted and not used. One thread at a time; all Rt.
class ProcessData {
 public:
  /// All outlive it.
  ProcessData(can::Bus& bus, const CanopenDriveConfig& config, Now now) noexcept
      : bus_(bus), config_(config), now_(now), watch_(config.node, config.own_node) {}

  /// From now on, the drive has just been set up.
  void Begin() noexcept;
  /// Our heartbeat where it is due, SYNC, and its answer, which answered() tells of. False where the bus is
  /// lost.
  bool Exchange() noexcept;
  /// The drive answered the last SYNC in time.
  bool answered() const noexcept { return answered_; }
  /// Exchanges without an answer, up to the last one.
  uint64_t silent_ticks() const noexcept { return silent_ticks_; }

  /// Whether our heartbeats go out, from the next exchange on; they do at first.
  void SendHeartbeats(bool send) noexcept { sends_heartbeats_ = send; }
  /// False where it was not taken.
  bool Command(uint16_t controlword, int32_t torque_per_mille) noexcept;
  void Sync() noexcept;
  void Send(const can::Frame& frame) noexcept { bus_.Send(frame); }

  NodeWatch& watch() noexcept { return watch_; }
  const NodeWatch& watch() const noexcept { return watch_; }
  /// The newest SDO answer, once.
  std::optional<can::Frame> TakeSdoAnswer() noexcept;

 private:
  void Heartbeat(int64_t now_ns) noexcept;
  void Hear(const can::Frame& frame) noexcept;
  /// Takes what has come; false where the bus is lost.
  bool Drain() noexcept;
  /// Waits until every SYNC is answered; false where the bus is lost.
  bool AwaitAnswers(int64_t deadline_ns) noexcept;
  bool Ask(int64_t deadline_ns) noexcept;

  can::Bus& bus_;
  const CanopenDriveConfig& config_;
  const Now now_;
  NodeWatch watch_;
  std::optional<can::Frame> sdo_answer_;
  bool answered_ = false;
  uint64_t silent_ticks_ = 0;
  // SYNCs without an answer, and how many ticks have waited for them.
  int unanswered_ = 0;
  int listening_ticks_ = 0;
  bool sends_heartbeats_ = true;
  int64_t next_heartbeat_ns_ = 0;
};

}  // namespace mwidth::device::canopen
