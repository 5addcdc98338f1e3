#include "server/config_modbus.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <sstream>
#include <string>
#include <vector>

namespace mwidth::server {
namespace {

namespace modbus = device::modbus;

constexpr Range kWord{0, 65'535};
constexpr double kLargest = 1e6;

template <typename Enum, std::size_t kCount>
Enum ReadNamed(ConfigTable& table, std::string_view key, const std::array<const char*, kCount>& names,
               Enum otherwise) {
  const std::string name =
      table.OneOfOr(key, {names.begin(), names.end()}, names.at(static_cast<std::size_t>(otherwise)));
  return static_cast<Enum>(std::find(names.begin(), names.end(), name) - names.begin());
}

uint16_t ReadWord(ConfigTable& table, std::string_view key) {
  return static_cast<uint16_t>(table.Integer(key, kWord));
}

modbus::RegisterValue ReadValue(ConfigTable& table) {
  modbus::RegisterValue value{
      .address = ReadWord(table, "address"),
      .type = ReadNamed(table, "type", modbus::kRegisterTypeNames, modbus::RegisterType::kInt16),
      .order = ReadNamed(table, "order", modbus::kWordOrderNames, modbus::WordOrder::kAbcd),
      .scale = table.Number("scale", {-kLargest, kLargest}),
      .offset = table.NumberOr("offset", {-kLargest, kLargest}, 0)};
  if (value.scale == 0) {
    table.Refuse("scale",
                 "is 0; give the quantity of one count, negative where the drive counts the other way");
  }
  if (static_cast<double>(value.address + value.Registers() - 1) > kWord.max) {
    table.Refuse("address", "leaves no room for the second register of the value");
  }
  return value;
}

// The quantity of one count: given for a float32, the scale for whole numbers.
double ReadQuantum(ConfigTable& table, const modbus::RegisterValue& value) {
  return value.type == modbus::RegisterType::kFloat32 ? table.Number("quantum", {0, kLargest, true})
                                                      : std::abs(value.scale);
}

modbus::LinkConfig ReadLink(ConfigTable& drive, bool tcp) {
  modbus::LinkConfig link;
  if (tcp) {
    const std::string host = drive.String("host");
    if (host.empty()) {
      drive.Refuse("host", "is empty; give the drive's name or address");
    }
    link.peer = modbus::TcpAddress{
        .host = host, .port = static_cast<uint16_t>(drive.IntegerOr("port", {1, kWord.max}, 502))};
  } else {
    modbus::SerialLine line{.device = drive.String("device"),
                            .baud = drive.IntegerOr("baud", {1200, 4'000'000}, 115'200),
                            .parity = drive.OneOfOr("parity", {"N", "E", "O"}, "N").front(),
                            .stop_bits = drive.IntegerOr("stop_bits", {1, 2}, 1)};
    link.peer = std::move(line);
  }
  // 0 is everybody, whom no answer comes from; 248 and above are for TCP alone.
  link.unit = static_cast<uint8_t>(drive.IntegerOr("unit", {1, tcp ? 255.0 : 247.0}, 1));
  return link;
}

/// Registers that something uses.
struct Use {
  std::string name;
  int first = 0;
  int last = 0;
};

Use UseOf(const std::string& name, const modbus::RegisterValue& value) {
  return {name, value.address, value.address + static_cast<int>(value.Registers()) - 1};
}

void CheckOverlaps(const ConfigTable& drive, const modbus::DriveMap& map) {
  std::vector<Use> uses{UseOf("position", map.position), UseOf("force", map.force)};
  if (map.enable) {
    uses.push_back({"enable", map.enable->address, map.enable->address});
  }
  if (map.watchdog) {
    uses.push_back(UseOf("watchdog", map.watchdog->timeout));
    uses.push_back({"watchdog's reaction", map.watchdog->reaction, map.watchdog->reaction});
  }
  for (std::size_t i = 0; i < uses.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (uses[i].first <= uses[j].last && uses[j].first <= uses[i].last) {
        drive.Refuse(uses[i].name == "watchdog's reaction" ? "watchdog" : uses[i].name,
                     "lies on the registers of " + uses[j].name + "; every value has registers of its own");
      }
    }
  }
}

void CheckForce(ConfigTable& force, const modbus::RegisterValue& value, double force_limit) {
  for (const double extreme : {force_limit, -force_limit}) {
    const double raw = (extreme - value.offset) / value.scale;
    if (!(raw >= value.RawMin() && raw <= value.RawMax())) {
      std::ostringstream text;
      text << "cannot hold " << extreme << ", which limits.force allows: that is " << raw << " counts";
      force.Refuse("type", text.str());
    }
  }
}

modbus::TickExchange ReadExchange(ConfigTable& drive, const model::LoopParameters& loop) {
  const bool one = drive.OneOfOr("exchange", {"two-requests", "read-write"}, "two-requests") == "read-write";
  if (one && loop.delay_s < loop.period_s) {
    drive.Refuse("exchange",
                 "is \"read-write\", which delays the force by a period: axis.loop.delay_s must be at least "
                 "axis.loop.period_s, or use \"two-requests\"");
  }
  return one ? modbus::TickExchange::kReadWrite : modbus::TickExchange::kTwoRequests;
}

std::optional<modbus::EnableRegister> ReadEnable(ConfigTable& drive) {
  auto table = drive.OptionalTable("enable");
  if (!table) {
    return std::nullopt;
  }
  const modbus::EnableRegister enable{.address = ReadWord(*table, "address"),
                                      .enabled = ReadWord(*table, "enabled"),
                                      .disabled = ReadWord(*table, "disabled")};
  if (enable.enabled == enable.disabled) {
    table->Refuse("disabled", "must differ from enabled");
  }
  table->Finish();
  return enable;
}

std::optional<modbus::WatchdogRegisters> ReadWatchdog(ConfigTable& drive) {
  auto table = drive.OptionalTable("watchdog");
  if (!table) {
    return std::nullopt;
  }
  const modbus::WatchdogRegisters watchdog{.timeout = ReadValue(*table),
                                           .reaction = ReadWord(*table, "reaction_address"),
                                           .no_reaction = ReadWord(*table, "no_reaction")};
  table->Finish();
  return watchdog;
}

}  // namespace

modbus::ModbusDriveConfig ReadModbusDrive(ConfigTable& drive, bool tcp, const model::LoopParameters& loop,
                                          double force_limit) {
  modbus::ModbusDriveConfig read;
  read.link = ReadLink(drive, tcp);
  read.exchange = ReadExchange(drive, loop);
  const double exchanges = read.exchange == modbus::TickExchange::kTwoRequests ? 2 : 1;
  read.reply_deadline_s =
      drive.NumberOr("reply_deadline_s", {1e-5, 0.9 * loop.period_s / exchanges}, 0.4 * loop.period_s);
  read.without_watchdog = drive.BooleanOr("without_watchdog", false);

  ConfigTable position = drive.Table("position");
  read.map.position = ReadValue(position);
  read.position_quantum = ReadQuantum(position, read.map.position);
  position.Finish();
  ConfigTable force = drive.Table("force");
  read.map.force = ReadValue(force);
  read.force_quantum = ReadQuantum(force, read.map.force);
  CheckForce(force, read.map.force, force_limit);
  force.Finish();
  read.map.enable = ReadEnable(drive);
  read.map.watchdog = ReadWatchdog(drive);
  CheckOverlaps(drive, read.map);
  return read;
}

}  // namespace mwidth::server
