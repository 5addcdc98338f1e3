#include "server/config_canopen.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <sstream>
#include <string>

#include "device/drive.h"

namespace mwidth::server {
namespace {

namespace can = device::can;
namespace canopen = device::canopen;

constexpr double kLargest = 1e6;
constexpr double kMillisecond = 1e-3;
constexpr double kMaxPerMille = std::numeric_limits<int16_t>::max();
// In the order of canopen::ConnectionLoss, from 1.
constexpr std::array<const char*, 3> kConnectionLossNames{"fault", "disable-voltage", "quick-stop"};

std::string ReadName(ConfigTable& table, std::string_view key, const char* what) {
  std::string name = table.String(key);
  if (name.empty()) {
    table.Refuse(key, std::string("is empty; give ") + what);
  }
  // The names go into lines of text, and into the kernel's fields of 16 bytes.
  constexpr std::size_t kLongestInterface = 15;
  if (key == "interface" &&
      (name.size() > kLongestInterface || name.find_first_of(" \t\r\n<>") != std::string::npos)) {
    table.Refuse(key, "is no name of an interface: at most 15 characters, without spaces and < >");
  }
  return name;
}

can::BusConfig ReadBus(ConfigTable bus) {
  can::BusConfig read;
  if (bus.OneOf("type", {"socketcan", "socketcand"}) == "socketcan") {
    read = can::SocketCan{.interface = ReadName(bus, "interface", "the controller, such as can0")};
  } else {
    read = can::Socketcand{.host = ReadName(bus, "host", "the gateway's name or address"),
                           .port = static_cast<uint16_t>(bus.IntegerOr("port", {1, 65'535}, 29'536)),
                           .interface = ReadName(bus, "interface", "the gateway's controller, such as can0")};
  }
  bus.Finish();
  return read;
}

double ReadMilliseconds(ConfigTable& table, std::string_view key, Range allowed, double otherwise) {
  const double value_s = table.NumberOr(key, allowed, otherwise);
  const double whole_s = std::round(value_s / kMillisecond) * kMillisecond;
  if (std::abs(value_s - whole_s) > 1e-9) {
    table.Refuse(key, "is no whole number of milliseconds, which is what CANopen counts");
  }
  return whole_s;
}

void ReadHeartbeats(ConfigTable& drive, double period_s, canopen::CanopenDriveConfig& read) {
  read.watchdog_s = ReadMilliseconds(drive, "watchdog_s", {2 * kMillisecond, device::kMaxWatchdogS}, 0.05);
  // Two of ours fit into the drive's patience, so that one may be late. They go out with ticks.
  const double longest_s = std::max(period_s, read.watchdog_s / 2 - period_s);
  read.heartbeat_s = drive.NumberOr("heartbeat_s", {period_s, longest_s}, std::min(0.02, longest_s));
  if (2 * (read.heartbeat_s + period_s) > read.watchdog_s + 1e-9) {
    drive.Refuse("watchdog_s", "is too short for this loop: it must hold four of axis.loop.period_s");
  }
  read.drive_heartbeat_s = ReadMilliseconds(drive, "drive_heartbeat_s", {5 * kMillisecond, 1}, 0.05);
  const std::string loss = drive.OneOfOr(
      "connection_loss", {kConnectionLossNames.begin(), kConnectionLossNames.end()}, "disable-voltage");
  const auto* const found = std::find(kConnectionLossNames.begin(), kConnectionLossNames.end(), loss);
  read.connection_loss =
      static_cast<canopen::ConnectionLoss>(std::distance(kConnectionLossNames.begin(), found) + 1);
  read.without_watchdog = drive.BooleanOr("without_watchdog", false);
}

canopen::TickExchange ReadExchange(ConfigTable& drive, const model::LoopParameters& loop) {
  const bool on_sync = drive.OneOfOr("exchange", {"on-receipt", "on-sync"}, "on-receipt") == "on-sync";
  if (on_sync && loop.delay_s < loop.period_s) {
    drive.Refuse("exchange",
                 "is \"on-sync\", which delays the force by a period: axis.loop.delay_s must be at least "
                 "axis.loop.period_s, or use \"on-receipt\"");
  }
  return on_sync ? canopen::TickExchange::kOnSync : canopen::TickExchange::kOnReceipt;
}

// 60C2h: a whole number up to 255 of a power of ten.
void ReadInterpolation(const ConfigTable& drive, double period_s, canopen::CanopenDriveConfig& read) {
  constexpr double kMax = std::numeric_limits<uint8_t>::max();
  for (int exponent = -2; exponent >= -6; --exponent) {
    const double count = period_s / std::pow(10, exponent);
    const double whole = std::round(count);
    if (whole >= 1 && whole <= kMax && std::abs(count - whole) < 1e-6) {
      read.interpolation_period = static_cast<uint8_t>(whole);
      read.interpolation_exponent = static_cast<int8_t>(exponent);
      return;
    }
  }
  drive.Refuse(
      "type",
      "is \"canopen\", whose object 60C2h cannot hold axis.loop.period_s: it must be a whole number, up "
      "to 255, of 10 ms, 1 ms, 0.1 ms, 10 us or 1 us");
}

double ReadPositionScale(ConfigTable position) {
  const double scale = position.Number("scale", {-kLargest, kLargest});
  if (scale == 0) {
    position.Refuse("scale",
                    "is 0; give the position of one count, negative where the drive counts the other way");
  }
  position.Finish();
  return scale;
}

void ReadTorque(ConfigTable torque, double force_limit, canopen::CanopenDriveConfig& read) {
  // 6076h counts thousandths in 32 bits.
  read.rated_torque = torque.Number("rated", {0.001, 4e6});
  read.gear = torque.NumberOr("gear", {0, kLargest, true}, 1);
  read.torque_reversed = torque.BooleanOr("reversed", false);
  read.max_torque_per_mille =
      static_cast<uint16_t>(torque.IntegerOr("max_per_mille", {1, kMaxPerMille}, 1000));
  const double largest = read.max_torque_per_mille * read.ForceQuantum();
  if (force_limit > largest) {
    std::ostringstream text;
    text << "lets the drive give at most " << largest << ", and limits.force allows " << force_limit;
    torque.Refuse("max_per_mille", text.str());
  }
  torque.Finish();
}

}  // namespace

canopen::CanopenDriveConfig ReadCanopenDrive(ConfigTable& drive, const model::LoopParameters& loop,
                                             double force_limit) {
  canopen::CanopenDriveConfig read;
  read.bus = ReadBus(drive.Table("bus"));
  read.node = static_cast<uint8_t>(drive.Integer("node", {1, canopen::kMaxNode}));
  read.own_node =
      static_cast<uint8_t>(drive.IntegerOr("own_node", {1, canopen::kMaxNode}, canopen::kMaxNode));
  if (read.own_node == read.node) {
    drive.Refuse("own_node", "is the drive's number; every node of a bus has one of its own");
  }
  read.exchange = ReadExchange(drive, loop);
  read.reply_deadline_s =
      drive.NumberOr("reply_deadline_s", {1e-5, 0.9 * loop.period_s}, 0.4 * loop.period_s);
  read.position_scale = ReadPositionScale(drive.Table("position"));
  ReadTorque(drive.Table("torque"), force_limit, read);
  ReadInterpolation(drive, loop.period_s, read);
  ReadHeartbeats(drive, loop.period_s, read);
  read.quick_stop_option = static_cast<int16_t>(drive.IntegerOr("quick_stop_option", {0, 3}, 0));
  return read;
}

}  // namespace mwidth::server
