// [axis.drive] of a Modbus drive: deploy/config/modbus.toml, and what is wrong with its like.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "server/config.h"

namespace mwidth::server {
namespace {

namespace modbus = device::modbus;
using testing::AllOf;
using testing::HasSubstr;

class ModbusConfigTest : public testing::Test {
 protected:
  static AxisConfig Load(const std::string& from = "", const std::string& to = "") {
    std::stringstream text;
    text << std::ifstream(CONFIG_DIR "/modbus.toml").rdbuf();
    std::string changed = text.str();
    const std::size_t at = changed.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    changed.replace(at, from.size(), to);
    const std::filesystem::path file =
        testing::TempDir() + testing::UnitTest::GetInstance()->current_test_info()->name() + ".toml";
    std::ofstream(file) << changed;
    return LoadConfig(file).axes.at(0);
  }
  static std::string ErrorAfter(const std::string& from, const std::string& to) {
    try {
      Load(from, to);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "accepted";
  }
};

TEST_F(ModbusConfigTest, ReadsTheExample) {
  const DriveConfig drive = Load().drive;
  EXPECT_FALSE(drive.simulated());
  EXPECT_EQ(drive.position_quantum, 7.1585e-5);
  EXPECT_EQ(drive.force_quantum, 0.001);
  const auto& read = std::get<modbus::ModbusDriveConfig>(drive.behind);
  EXPECT_EQ(std::get<modbus::TcpAddress>(read.link.peer).host, "192.168.0.10");
  EXPECT_EQ(read.exchange, modbus::TickExchange::kTwoRequests);
  EXPECT_EQ(read.reply_deadline_s, 0.0008);
  EXPECT_FALSE(read.without_watchdog);
  EXPECT_EQ(read.map.position.address, 100);
  EXPECT_EQ(read.map.position.type, modbus::RegisterType::kInt32);
  EXPECT_EQ(read.map.force.type, modbus::RegisterType::kInt16);
  ASSERT_TRUE(read.map.enable.has_value());
  EXPECT_EQ(read.map.enable->address, 300);
  ASSERT_TRUE(read.map.watchdog.has_value());
  EXPECT_EQ(read.map.watchdog->timeout.scale, 0.001);
  EXPECT_EQ(read.map.watchdog->reaction, 401);
}

TEST_F(ModbusConfigTest, ReadsASerialLine) {
  const DriveConfig drive = Load(R"(type = "modbus-tcp"
host = "192.168.0.10"
port = 502)",
                                 R"(type = "modbus-rtu"
device = "/dev/ttyUSB0"
parity = "E")")
                                .drive;
  const auto& line =
      std::get<modbus::SerialLine>(std::get<modbus::ModbusDriveConfig>(drive.behind).link.peer);
  EXPECT_EQ(line.device, "/dev/ttyUSB0");
  EXPECT_EQ(line.baud, 115'200);
  EXPECT_EQ(line.parity, 'E');
}

TEST_F(ModbusConfigTest, RefusesRegistersThatOverlapOrDoNotExist) {
  EXPECT_THAT(ErrorAfter("address = 200", "address = 101"),
              AllOf(HasSubstr("axis.drive.force"), HasSubstr("lies on the registers of position")));
  EXPECT_THAT(ErrorAfter("reaction_address = 401", "reaction_address = 300"),
              AllOf(HasSubstr("axis.drive.watchdog"), HasSubstr("registers of enable")));
  EXPECT_THAT(ErrorAfter("address = 100", "address = 65535"), HasSubstr("no room for the second register"));
  EXPECT_THAT(ErrorAfter("address = 100", "address = 65536"), HasSubstr("from 0 to 65535"));
}

TEST_F(ModbusConfigTest, RefusesValuesThatCannotBe) {
  EXPECT_THAT(ErrorAfter("order = \"ABCD\"", "order = \"ACBD\""),
              HasSubstr("allowed are \"ABCD\", \"CDAB\", \"BADC\", \"DCBA\""));
  EXPECT_THAT(ErrorAfter("type = \"int32\"", "type = \"float32\""),
              HasSubstr("axis.drive.position.quantum is missing"));
  EXPECT_THAT(ErrorAfter("scale = 7.1585e-5", "scale = 0"), HasSubstr("axis.drive.position.scale is 0"));
  EXPECT_THAT(ErrorAfter("disabled = 0", "disabled = 1"), HasSubstr("must differ from enabled"));
  EXPECT_THAT(ErrorAfter("unit = 1", "unit = 0"), HasSubstr("axis.drive.unit is 0"));
}

TEST_F(ModbusConfigTest, RefusesAForceThatItsRegisterCannotHold) {
  EXPECT_THAT(ErrorAfter("force = 10.0", "force = 40.0"),
              AllOf(HasSubstr("axis.drive.force.type cannot hold 40"), HasSubstr("40000 counts")));
  EXPECT_THAT(ErrorAfter("type = \"int16\"", "type = \"uint16\""), HasSubstr("cannot hold -10"));
}

TEST_F(ModbusConfigTest, RefusesExchangesThatDoNotFitIntoTheLoop) {
  EXPECT_THAT(ErrorAfter("exchange = \"two-requests\"", "exchange = \"read-write\""),
              HasSubstr("delay_s must be at least axis.loop.period_s"));
  EXPECT_THAT(ErrorAfter("reply_deadline_s = 0.0008", "reply_deadline_s = 0.001"),
              HasSubstr("axis.drive.reply_deadline_s is 0.001"));
}

}  // namespace
}  // namespace mwidth::server
