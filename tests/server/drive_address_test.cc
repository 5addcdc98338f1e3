#include "server/drive_address.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <variant>

namespace mwidth::server {
namespace {

namespace can = device::can;
namespace canopen = device::canopen;
namespace modbus = device::modbus;
using testing::HasSubstr;

AxisConfig With(decltype(DriveConfig::behind) behind) {
  AxisConfig axis;
  axis.name = "elbow";
  axis.drive.behind = std::move(behind);
  return axis;
}

modbus::LinkConfig ModbusAt(const std::string& address, modbus::LinkConfig configured = {}) {
  modbus::ModbusDriveConfig drive;
  drive.link = std::move(configured);
  AxisConfig axis = With(drive);
  PlaceDrive(address, axis);
  return std::get<modbus::ModbusDriveConfig>(axis.drive.behind).link;
}

can::BusConfig BusAt(const std::string& address, can::BusConfig configured) {
  AxisConfig axis = With(canopen::CanopenDriveConfig{.bus = std::move(configured)});
  PlaceDrive(address, axis);
  return std::get<canopen::CanopenDriveConfig>(axis.drive.behind).bus;
}

std::string ErrorOf(const std::string& address, AxisConfig axis) {
  try {
    PlaceDrive(address, axis);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "taken";
}

TEST(DriveAddressTest, AHostAndPortIsModbusTcp) {
  const auto link = ModbusAt("robot:1502", {.peer = modbus::SerialLine{.device = "/dev/ttyS0"}, .unit = 7});
  EXPECT_EQ(std::get<modbus::TcpAddress>(link.peer).host, "robot");
  EXPECT_EQ(std::get<modbus::TcpAddress>(link.peer).port, 1502);
  EXPECT_EQ(link.unit, 7);
}

TEST(DriveAddressTest, AnIpv6AddressStandsInBrackets) {
  const auto link = ModbusAt("[fe80::1]:502");
  EXPECT_EQ(std::get<modbus::TcpAddress>(link.peer).host, "fe80::1");
}

TEST(DriveAddressTest, APathIsASerialLineThatKeepsItsSettings) {
  const auto line = std::get<modbus::SerialLine>(
      ModbusAt("/dev/pts/3", {.peer = modbus::SerialLine{.device = "/dev/ttyS0", .baud = 19'200}}).peer);
  EXPECT_EQ(line.device, "/dev/pts/3");
  EXPECT_EQ(line.baud, 19'200);
}

TEST(DriveAddressTest, APathInPlaceOfAHostHasTheUsualSerialSettings) {
  const auto line = std::get<modbus::SerialLine>(ModbusAt("/dev/pts/3").peer);
  EXPECT_EQ(line.device, "/dev/pts/3");
  EXPECT_EQ(line.baud, modbus::SerialLine{}.baud);
}

TEST(DriveAddressTest, AWordIsACanInterface) {
  EXPECT_EQ(std::get<can::SocketCan>(BusAt("vcan0", can::Socketcand{.host = "gateway", .interface = "can0"}))
                .interface,
            "vcan0");
}

TEST(DriveAddressTest, AHostAndPortIsACanGatewayToTheSameInterface) {
  const auto gateway = std::get<can::Socketcand>(BusAt("gateway:29536", can::SocketCan{.interface = "can1"}));
  EXPECT_EQ(gateway.host, "gateway");
  EXPECT_EQ(gateway.port, 29'536);
  EXPECT_EQ(gateway.interface, "can1");
}

TEST(DriveAddressTest, RefusesWhatIsNoAddressOfSuchADrive) {
  for (const char* address : {"", "can0", "robot:", "robot:0", "robot:65536", "robot:5x", ":502"}) {
    EXPECT_THAT(ErrorOf(address, With(modbus::ModbusDriveConfig{})), HasSubstr("HOST:PORT or the path"))
        << address;
  }
  for (const char* address : {"", "/dev/ttyS0", "robot:", "can 0"}) {
    EXPECT_THAT(ErrorOf(address, With(canopen::CanopenDriveConfig{})), HasSubstr("a CAN interface, or"))
        << address;
  }
  EXPECT_THAT(ErrorOf("robot:502", With(HandMotionConfig{})), HasSubstr("simulated drive, which is nowhere"));
}

}  // namespace
}  // namespace mwidth::server
