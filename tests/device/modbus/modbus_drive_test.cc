#include "device/modbus/modbus_drive.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <stdexcept>
#include <thread>

#include "tests/device/modbus/register_server.h"

namespace mwidth::device::modbus {
namespace {

using modbus::testing::Bytes;
using modbus::testing::Listener;
using modbus::testing::Registers;
using modbus::testing::ScriptedPeer;
using ::testing::HasSubstr;

constexpr uint16_t kPosition = 100;
constexpr uint16_t kForce = 200;
constexpr uint16_t kEnable = 300;
constexpr uint16_t kTimeout = 400;
constexpr uint16_t kReaction = 401;

// The time of the drive's silences, which stands still unless a test moves it.
std::atomic<int64_t> now_ns{0};
int64_t TestNow() noexcept { return now_ns; }
// 1.5 times the slowest watchdog that a drive is armed with.
constexpr int64_t kSilenceNs = 150'000'000;

class ModbusDriveTest : public ::testing::Test {
 protected:
  ModbusDriveTest() {
    SetPosition(0);
    registers.Set(kForce, 77);
    registers.Set(kEnable, 1);
    registers.Set(kTimeout, 50);
    registers.Set(kReaction, 2);
    accepting = std::jthread([this](const std::stop_token& stop) { Accept(stop); });
  }
  ~ModbusDriveTest() override {
    accepting.request_stop();
    shutdown(listener.file(), SHUT_RDWR);
  }

  void Accept(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      const int file = listener.Accept();
      if (file >= 0) {
        peer = std::make_unique<ScriptedPeer>(file, [this](const Bytes& request) {
          return hang_up ? modbus::testing::Pieces{{}} : registers.Answer(request);
        });
      }
    }
  }
  void SetPosition(int32_t counts) {
    registers.Set(kPosition, static_cast<uint16_t>(static_cast<uint32_t>(counts) >> 16));
    registers.Set(kPosition + 1, static_cast<uint16_t>(static_cast<uint32_t>(counts)));
  }
  ModbusDriveConfig Config() const {
    return {.link = {.peer = TcpAddress{.host = "127.0.0.1", .port = listener.port()}, .unit = 1},
            .map = {.position = {.address = kPosition, .type = RegisterType::kInt32, .scale = 1e-4},
                    .force = {.address = kForce, .type = RegisterType::kInt16, .scale = 0.01},
                    .enable = EnableRegister{.address = kEnable, .enabled = 1, .disabled = 0},
                    .watchdog =
                        WatchdogRegisters{
                            .timeout = {.address = kTimeout, .type = RegisterType::kUint16, .scale = 1e-3},
                            .reaction = kReaction,
                            .no_reaction = 0}},
            .reply_deadline_s = 0.3};
  }
  // For as long as the drive's watchdog may take, reads say nothing and send nothing; then they may again.
  void ExpectSilence(ModbusDrive& drive) {
    const int before = registers.requests();
    EXPECT_FALSE(drive.Read(1).ok);
    now_ns += kSilenceNs - 1;
    EXPECT_FALSE(drive.Read(2).ok);
    EXPECT_EQ(drive.Enable(), Enabling::kSilent);
    EXPECT_EQ(registers.requests(), before);
    now_ns += 1;
  }

  Listener listener;
  Registers registers;
  std::atomic<bool> hang_up{false};
  std::unique_ptr<ScriptedPeer> peer;
  std::jthread accepting;
};

TEST_F(ModbusDriveTest, TakesTheForceAwayWhenItConnectsAndWhenItGoes) {
  {
    const ModbusDrive drive(Config());
    EXPECT_EQ(registers.Get(kForce), 0);
    EXPECT_EQ(registers.Get(kEnable), 0);
    registers.Set(kForce, 5);
    registers.Set(kEnable, 1);
  }
  EXPECT_EQ(registers.Get(kForce), 0);
  EXPECT_EQ(registers.Get(kEnable), 0);
}

TEST_F(ModbusDriveTest, ReadsPositionsAndWritesForcesInCounts) {
  ModbusDrive drive(Config());
  EXPECT_DOUBLE_EQ(drive.Info().position_quantum, 1e-4);
  EXPECT_DOUBLE_EQ(drive.Info().force_quantum, 0.01);
  EXPECT_EQ(drive.Info().position_bits, 32);
  EXPECT_FALSE(drive.Info().simulated);
  SetPosition(-123'456);
  const Reading reading = drive.Read(1);
  EXPECT_TRUE(reading.ok);
  EXPECT_EQ(reading.position_counts, -123'456);
  ASSERT_EQ(drive.Enable(), Enabling::kEnabled);
  EXPECT_EQ(registers.Get(kEnable), 1);
  // The paper's force acts against the positive direction.
  EXPECT_TRUE(drive.Write(250));
  EXPECT_EQ(static_cast<int16_t>(registers.Get(kForce)), -250);
  drive.Disable();
  EXPECT_EQ(registers.Get(kForce), 0);
  EXPECT_EQ(registers.Get(kEnable), 0);
}

TEST_F(ModbusDriveTest, CountsTheOtherWayWhereTheScalesAreNegative) {
  ModbusDriveConfig config = Config();
  config.map.position.scale = -1e-4;
  config.map.position.offset = 0.5;
  config.map.force.scale = -0.01;
  ModbusDrive drive(config);
  SetPosition(1000);
  EXPECT_EQ(drive.Read(1).position_counts, 4000);
  ASSERT_EQ(drive.Enable(), Enabling::kEnabled);
  drive.Write(250);
  EXPECT_EQ(static_cast<int16_t>(registers.Get(kForce)), 250);
}

TEST_F(ModbusDriveTest, InOneRequestTheForceIsThatOfTheTickBefore) {
  ModbusDriveConfig config = Config();
  config.exchange = TickExchange::kReadWrite;
  ModbusDrive drive(config);
  ASSERT_EQ(drive.Enable(), Enabling::kEnabled);
  const int before = registers.requests();
  EXPECT_TRUE(drive.Read(1).ok);
  EXPECT_TRUE(drive.Write(30));
  EXPECT_EQ(registers.Get(kForce), 0);
  EXPECT_TRUE(drive.Read(2).ok);
  EXPECT_EQ(static_cast<int16_t>(registers.Get(kForce)), -30);
  EXPECT_EQ(registers.requests() - before, 2);
}

TEST_F(ModbusDriveTest, IsNotArmedWithoutAWatchdogThatReacts) {
  ModbusDrive drive(Config());
  registers.Set(kTimeout, 101);
  EXPECT_EQ(drive.Enable(), Enabling::kNoWatchdog);
  registers.Set(kTimeout, 0);
  EXPECT_EQ(drive.Enable(), Enabling::kNoWatchdog);
  registers.Set(kTimeout, 100);
  registers.Set(kReaction, 0);
  EXPECT_EQ(drive.Enable(), Enabling::kNoWatchdog);
  EXPECT_EQ(registers.Get(kEnable), 0);
  registers.Set(kReaction, 1);
  EXPECT_EQ(drive.Enable(), Enabling::kEnabled);
}

TEST_F(ModbusDriveTest, IsArmedWithoutOneOnlyWhereThatIsConfigured) {
  ModbusDriveConfig config = Config();
  config.map.watchdog.reset();
  {
    ModbusDrive drive(config);
    EXPECT_EQ(drive.Enable(), Enabling::kNoWatchdog);
  }
  config.without_watchdog = true;
  ModbusDrive drive(config);
  EXPECT_EQ(drive.Enable(), Enabling::kEnabled);
}

TEST_F(ModbusDriveTest, ARegisterThatIsNotThereIsTold) {
  ModbusDriveConfig config = Config();
  config.map.watchdog->reaction = 999;
  ModbusDrive drive(config);
  EXPECT_EQ(drive.Enable(), Enabling::kRefused);
  EXPECT_EQ(drive.counters().exceptions, 1);
}

TEST_F(ModbusDriveTest, ASilentDriveIsSilentInReadAndWrite) {
  ModbusDriveConfig config = Config();
  config.reply_deadline_s = 0.05;
  ModbusDrive drive(config, TestNow);
  ASSERT_EQ(drive.Enable(), Enabling::kEnabled);
  registers.FallSilent(true);
  EXPECT_FALSE(drive.Read(1).ok);
  EXPECT_FALSE(drive.Write(1));
  EXPECT_EQ(drive.Enable(), Enabling::kSilent);
  registers.FallSilent(false);
  now_ns += kSilenceNs;
  EXPECT_FALSE(drive.Read(2).ok);
  EXPECT_TRUE(drive.Read(3).ok);
}

TEST_F(ModbusDriveTest, LeavesADriveThatDidNotDisableToItsWatchdogAndTriesAgain) {
  ModbusDrive drive(Config(), TestNow);
  ASSERT_EQ(drive.Enable(), Enabling::kEnabled);
  ASSERT_TRUE(drive.Write(100));
  registers.RefuseWrites({kForce, kEnable});
  drive.Disable();
  ExpectSilence(drive);
  // Tried again, in vain.
  const int before = registers.requests();
  EXPECT_FALSE(drive.Read(3).ok);
  EXPECT_EQ(registers.requests() - before, 2);
  ExpectSilence(drive);
  registers.RefuseWrites({});
  EXPECT_EQ(static_cast<int16_t>(registers.Get(kForce)), -100);
  EXPECT_FALSE(drive.Read(4).ok);
  EXPECT_EQ(registers.Get(kForce), 0);
  EXPECT_EQ(registers.Get(kEnable), 0);
  EXPECT_TRUE(drive.Read(5).ok);
  EXPECT_EQ(drive.Enable(), Enabling::kEnabled);
}

TEST_F(ModbusDriveTest, IsDisabledByEitherOfTheTwoWrites) {
  ModbusDrive drive(Config(), TestNow);
  for (const uint16_t refused : {kForce, kEnable}) {
    ASSERT_EQ(drive.Enable(), Enabling::kEnabled);
    registers.RefuseWrites({refused});
    drive.Disable();
    EXPECT_TRUE(drive.Read(1).ok);
    registers.RefuseWrites({});
  }
}

TEST_F(ModbusDriveTest, WithoutAnEnableRegisterOnlyAForceOfZeroDisables) {
  ModbusDriveConfig config = Config();
  config.map.enable.reset();
  ModbusDrive drive(config, TestNow);
  ASSERT_EQ(drive.Enable(), Enabling::kEnabled);
  registers.RefuseWrites({kForce});
  drive.Disable();
  ExpectSilence(drive);
  registers.RefuseWrites({});
  EXPECT_FALSE(drive.Read(3).ok);
  EXPECT_TRUE(drive.Read(4).ok);
}

TEST_F(ModbusDriveTest, AnEnablingThatFailedIsTakenBackLikeAnyOther) {
  ModbusDrive drive(Config(), TestNow);
  EXPECT_TRUE(drive.Read(1).ok);
  registers.RefuseWrites({kForce, kEnable});
  EXPECT_EQ(drive.Enable(), Enabling::kRefused);
  ExpectSilence(drive);
  registers.RefuseWrites({});
  EXPECT_FALSE(drive.Read(3).ok);
  EXPECT_TRUE(drive.Read(4).ok);
}

TEST_F(ModbusDriveTest, TakesNoForceUnlessItIsEnabled) {
  ModbusDrive drive(Config());
  EXPECT_FALSE(drive.Write(100));
  EXPECT_EQ(registers.Get(kForce), 0);
}

TEST_F(ModbusDriveTest, APositionThatIsNoNumberIsNoReading) {
  ModbusDriveConfig config = Config();
  config.map.position.type = RegisterType::kFloat32;
  config.position_quantum = 1e-5;
  ModbusDrive drive(config);
  SetPosition(0x3F800000);  // 1.0
  EXPECT_EQ(drive.Read(1).position_counts, 10);
  SetPosition(0x7FC00000);
  EXPECT_FALSE(drive.Read(2).ok);
  SetPosition(0x7F800000);
  EXPECT_FALSE(drive.Read(3).ok);
}

TEST_F(ModbusDriveTest, ALostConnectionComesBackDisabled) {
  ModbusDrive drive(Config(), TestNow);
  ASSERT_EQ(drive.Enable(), Enabling::kEnabled);
  ASSERT_TRUE(drive.Write(100));
  hang_up = true;
  EXPECT_FALSE(drive.Read(1).ok);
  EXPECT_FALSE(drive.Write(100));
  drive.Disable();
  hang_up = false;
  // No silence: who connected it anew took the force away.
  while (!drive.Read(2).ok) {
    std::this_thread::yield();
  }
  EXPECT_FALSE(drive.Write(100));
  EXPECT_EQ(registers.Get(kForce), 0);
  EXPECT_EQ(registers.Get(kEnable), 0);
  EXPECT_EQ(drive.Enable(), Enabling::kEnabled);
}

TEST_F(ModbusDriveTest, ThatTakesNoForceIsNotServed) {
  registers.FallSilent(true);
  try {
    const ModbusDrive drive(Config());
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("check its unit number"));
  }
}

}  // namespace
}  // namespace mwidth::device::modbus
