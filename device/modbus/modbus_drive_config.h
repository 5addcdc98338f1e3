// What there is to know about a Modbus drive before it is spoken to.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "device/modbus/register_value.h"

namespace mwidth::device::modbus {

/// Modbus TCP.
struct TcpAddress {
  /// Name or address, IPv4 or IPv6.
  std::string host;
  uint16_t port = 502;
};

/// Modbus RTU.
struct SerialLine {
  std::string device;
  int baud = 115'200;
  /// 'N', 'E' or 'O'.
  char parity = 'N';
  int stop_bits = 1;
};

struct LinkConfig {
  std::variant<TcpAddress, SerialLine> peer;
  /// Unit (slave) identifier: 1 to 247; Modbus TCP drives often want 255 or ignore it.
  uint8_t unit = 1;
};

/// A register that lets the motor follow, or not.
struct EnableRegister {
  uint16_t address = 0;
  uint16_t enabled = 1;
  uint16_t disabled = 0;
};

/// What the drive does by itself when nobody speaks to it any more.
struct WatchdogRegisters {
  /// Time after which it reacts, s.
  RegisterValue timeout;
  /// How it reacts; `no_reaction` means that it does not.
  uint16_t reaction = 0;
  uint16_t no_reaction = 0;
};

/// All quantities in rad and N m, or m and N.
struct DriveMap {
  /// `scale` is the position of one count.
  RegisterValue position;
  /// The motor's force or torque, positive towards rising positions; `scale` is that of one count.
  RegisterValue force;
  std::optional<EnableRegister> enable;
  std::optional<WatchdogRegisters> watchdog;
};

/// How a tick talks to the drive.
enum class TickExchange : uint8_t {
  /// Reads the position, then writes the force that follows from it: the least delay.
  kTwoRequests,
  /// Writes the last tick's force and reads the position in one request (function 23): half the messages, and
  /// one period
  /// of delay, which the loop's delay_s must hold.
  kReadWrite,
};

struct ModbusDriveConfig {
  LinkConfig link;
  DriveMap map;
  TickExchange exchange = TickExchange::kTwoRequests;
  /// Bound on each request and its reply, s; the tick has one or two of them.
  double reply_deadline_s = 0;
  /// Position and force of one count of a float32; for whole numbers their scale says it.
  double position_quantum = 0;
  double force_quantum = 0;
  /// Lets a drive without a proven watchdog be armed: then a dead server leaves the last force on the motor.
  bool without_watchdog = false;
};

}  // namespace mwidth::device::modbus
