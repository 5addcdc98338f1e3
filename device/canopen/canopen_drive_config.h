// What there is to know about a CiA 402 drive before it is spoken to.
#pragma once

#include <cstdint>

#include "device/can/bus_config.h"

namespace mwidth::device::canopen {

/// How a tick talks to the drive. Either way: SYNC, the drive's TPDO1 with statusword (6041h), position
/// (6064h) and torque (6077h), then RPDO1 with controlword (6040h) and target torque (6071h).
enum class TickExchange : uint8_t {
  /// RPDO1 is event-driven (type 255): the force acts as it comes. The least delay.
  kOnReceipt,
  /// RPDO1 is synchronous (type 1): the force acts with the next SYNC, a period later, which the loop's
  /// delay_s must hold. For drives that know no other cyclic mode.
  kOnSync,
};

inline constexpr uint8_t kMaxNode = 127;

/// Heartbeats of the drive that are missing when it is taken for gone.
inline constexpr double kMostHeartbeatsMissing = 3;

/// What the drive does when our heartbeat is missing: 6007h.
enum class ConnectionLoss : uint8_t { kNone = 0, kFault = 1, kDisableVoltage = 2, kQuickStop = 3 };

/// Linear: m, N; rotary: rad, N m; all at the axis, behind any gear.
struct CanopenDriveConfig {
  can::BusConfig bus;
  /// The drive's number and ours, 1 to kMaxNode, different.
  uint8_t node = 1;
  uint8_t own_node = kMaxNode;
  TickExchange exchange = TickExchange::kOnReceipt;
  /// Bound on the time from SYNC to the drive's TPDO, s.
  double reply_deadline_s = 0;

  /// Position of one count of 6064h; negative where the drive counts the other way.
  double position_scale = 0;
  /// What 6076h must say, times a thousand: the torque (force) of the motor itself that 1000 in 6071h means.
  double rated_torque = 0;
  /// Torque at the axis for a torque of the motor; above 0.
  double gear = 1;
  /// True where a positive torque turns towards falling positions (of the axis, not of the drive's counter).
  bool torque_reversed = false;
  /// 6072h: thousandths of the rated torque that the drive never exceeds.
  uint16_t max_torque_per_mille = 1000;

  /// The loop's period as 60C2h has it: period x 10^exponent s.
  uint8_t interpolation_period = 1;
  int8_t interpolation_exponent = -3;

  /// How often we send a heartbeat, and how long the drive does without it (1016h), s; whole milliseconds.
  double heartbeat_s = 0.02;
  double watchdog_s = 0.05;
  /// How often the drive sends its own (1017h), s; whole milliseconds.
  double drive_heartbeat_s = 0.05;
  /// What the drive does when ours is missing.
  ConnectionLoss connection_loss = ConnectionLoss::kDisableVoltage;
  /// 605Ah: what it does on a quick stop. 0 lets go of the motor, which is kind to a person who holds it.
  int16_t quick_stop_option = 0;
  /// Lets a drive without a proven watchdog be armed: then a dead server leaves the last force on the motor.
  bool without_watchdog = false;

  /// Force at the axis of one count of 6071h.
  double ForceQuantum() const noexcept { return rated_torque * gear / 1000; }
};

}  // namespace mwidth::device::canopen
