// [axis.drive] of a CANopen drive: deploy/config/canopen.toml, and what is wrong with its like.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "server/config.h"

namespace mwidth::server {
namespace {

namespace canopen = device::canopen;
namespace can = device::can;
using testing::AllOf;
using testing::HasSubstr;

class CanopenConfigTest : public testing::Test {
 protected:
  static AxisConfig Load(const std::string& from = "", const std::string& to = "") {
    std::stringstream text;
    text << std::ifstream(CONFIG_DIR "/canopen.toml").rdbuf();
    std::string changed = text.str();
    const std::size_t at = changed.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    changed.replace(at, from.size(), to);
    const std::filesystem::path file =
        testing::TempDir() + testing::UnitTest::GetInstance()->current_test_info()->name() + ".toml";
    std::ofstream(file) << changed;
    return LoadConfig(file).axes.at(0);
  }
  static canopen::CanopenDriveConfig Drive(const std::string& from = "", const std::string& to = "") {
    return std::get<canopen::CanopenDriveConfig>(Load(from, to).drive.behind);
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

TEST_F(CanopenConfigTest, ReadsTheExample) {
  const AxisConfig axis = Load();
  EXPECT_FALSE(axis.drive.simulated());
  EXPECT_EQ(axis.drive.position_quantum, 7.1585e-5);
  EXPECT_DOUBLE_EQ(axis.drive.force_quantum, 0.0125);
  const auto& read = std::get<canopen::CanopenDriveConfig>(axis.drive.behind);
  EXPECT_EQ(std::get<can::SocketCan>(read.bus).interface, "can0");
  EXPECT_EQ(read.node, 1);
  EXPECT_EQ(read.own_node, 127);
  EXPECT_EQ(read.exchange, canopen::TickExchange::kOnReceipt);
  EXPECT_EQ(read.reply_deadline_s, 0.0004);
  EXPECT_EQ(read.heartbeat_s, 0.02);
  EXPECT_EQ(read.watchdog_s, 0.05);
  EXPECT_EQ(read.drive_heartbeat_s, 0.05);
  EXPECT_EQ(read.connection_loss, canopen::ConnectionLoss::kDisableVoltage);
  EXPECT_EQ(read.rated_torque, 0.25);
  EXPECT_EQ(read.gear, 50);
  EXPECT_FALSE(read.torque_reversed);
  EXPECT_EQ(read.max_torque_per_mille, 1000);
  EXPECT_EQ(read.interpolation_period, 1);
  EXPECT_EQ(read.interpolation_exponent, -3);
  EXPECT_EQ(read.quick_stop_option, 0);
  EXPECT_FALSE(read.without_watchdog);
}

TEST_F(CanopenConfigTest, ReadsAGateway) {
  const std::string from = "type = \"socketcan\"\n";
  const auto gateway =
      std::get<can::Socketcand>(Drive(from, "type = \"socketcand\"\nhost = \"gateway\"\n").bus);
  EXPECT_EQ(gateway.host, "gateway");
  EXPECT_EQ(gateway.port, 29'536);
  EXPECT_EQ(gateway.interface, "can0");
  EXPECT_THAT(ErrorAfter(from, "type = \"socketcand\"\n"), HasSubstr("axis.drive.bus.host is missing"));
  EXPECT_THAT(ErrorAfter("interface = \"can0\"", "interface = \"can0 >< open\""),
              HasSubstr("is no name of an interface"));
}

TEST_F(CanopenConfigTest, SaysThePeriodAsTheDriveHasIt) {
  const auto drive = Drive("period_s = 0.001", "period_s = 0.00125");
  EXPECT_EQ(drive.interpolation_period, 125);
  EXPECT_EQ(drive.interpolation_exponent, -5);
  EXPECT_THAT(ErrorAfter("period_s = 0.001", "period_s = 0.0012345"),
              AllOf(HasSubstr("axis.drive.type"), HasSubstr("60C2h cannot hold axis.loop.period_s")));
}

TEST_F(CanopenConfigTest, ReadsEveryReactionToALostConnection) {
  const std::string from = "connection_loss = \"disable-voltage\"";
  EXPECT_EQ(Drive(from, "connection_loss = \"fault\"").connection_loss, canopen::ConnectionLoss::kFault);
  EXPECT_EQ(Drive(from, "connection_loss = \"quick-stop\"").connection_loss,
            canopen::ConnectionLoss::kQuickStop);
  EXPECT_THAT(ErrorAfter(from, "connection_loss = \"none\""), HasSubstr("allowed are \"fault\""));
}

TEST_F(CanopenConfigTest, RefusesNodesThatCannotBe) {
  EXPECT_THAT(ErrorAfter("node = 1", "node = 128"), HasSubstr("axis.drive.node is 128"));
  EXPECT_THAT(ErrorAfter("own_node = 127", "own_node = 1"), HasSubstr("is the drive's number"));
}

TEST_F(CanopenConfigTest, RefusesTimesThatDoNotFitTogether) {
  EXPECT_THAT(ErrorAfter("watchdog_s = 0.05", "watchdog_s = 0.125"),
              HasSubstr("axis.drive.watchdog_s is 0.125"));
  EXPECT_THAT(ErrorAfter("watchdog_s = 0.05", "watchdog_s = 0.0505"),
              HasSubstr("whole number of milliseconds"));
  EXPECT_THAT(ErrorAfter("heartbeat_s = 0.02", "heartbeat_s = 0.03"), HasSubstr("from 0.001 to 0.024"));
  EXPECT_THAT(ErrorAfter("reply_deadline_s = 0.0004", "reply_deadline_s = 0.001"),
              HasSubstr("axis.drive.reply_deadline_s is 0.001"));
  EXPECT_THAT(ErrorAfter("exchange = \"on-receipt\"", "exchange = \"on-sync\""),
              HasSubstr("delay_s must be at least axis.loop.period_s"));
}

TEST_F(CanopenConfigTest, RefusesQuantitiesThatTheDriveCannotGive) {
  EXPECT_THAT(ErrorAfter("scale = 7.1585e-5", "scale = 0"), HasSubstr("axis.drive.position.scale is 0"));
  EXPECT_THAT(ErrorAfter("max_per_mille = 1000", "max_per_mille = 799"),
              HasSubstr("at most 9.9875, and limits.force allows 10"));
  EXPECT_THAT(ErrorAfter("max_per_mille = 1000", "max_per_mille = 32768"),
              HasSubstr("max_per_mille is 32768"));
  EXPECT_THAT(ErrorAfter("rated = 0.25", "rated = 0"), HasSubstr("axis.drive.torque.rated is 0"));
}

TEST_F(CanopenConfigTest, RefusesASecondAxisOnTheSameBus) {
  std::stringstream text;
  text << std::ifstream(CONFIG_DIR "/canopen.toml").rdbuf();
  const std::string one = text.str();
  std::string second = one.substr(one.find("[[axis]]"));
  second.replace(second.find("elbow"), 5, "wrist");
  EXPECT_THAT(ErrorAfter("[[axis]]", second + "\n[[axis]]"), HasSubstr("each needs a bus of its own"));
  second.replace(second.find("\"can0\""), 6, "\"can1\"");
  EXPECT_THAT(ErrorAfter("[[axis]]", second + "\n[[axis]]"), testing::Not(HasSubstr("bus of its own")));
}

}  // namespace
}  // namespace mwidth::server
