#include "device/emulator/modbus_registers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <vector>

#include "device/modbus/frame.h"
#include "tests/device/emulator/still_joint.h"

namespace mwidth::device::emulator {
namespace {

using ::testing::ElementsAre;
using Bytes = std::vector<uint8_t>;

class ModbusRegistersTest : public ::testing::Test {
 protected:
  static modbus::ModbusDriveConfig Config() {
    using modbus::RegisterType;
    return {.link = {},
            .map = {.position = {.address = 100, .type = RegisterType::kInt32, .scale = 1e-4},
                    .force = {.address = 200, .type = RegisterType::kInt16, .scale = 0.01},
                    .enable = modbus::EnableRegister{.address = 300, .enabled = 15, .disabled = 6},
                    .watchdog =
                        modbus::WatchdogRegisters{
                            .timeout = {.address = 400, .type = RegisterType::kUint16, .scale = 1e-3},
                            .reaction = 401}},
            .position_quantum = 1e-4,
            .force_quantum = 0.01};
  }
  Bytes Ask(const modbus::Request& request) { return registers.Answer(request.pdu(), 1); }
  Bytes Put(uint16_t address, uint16_t word) {
    return Ask(modbus::WriteRegisters(address, std::array{word}));
  }

  Joint joint{StillJoint(0.05), std::make_unique<StillHand>()};
  LinkFaults faults;
  ModbusRegisters registers{Config(), joint, faults};
};

TEST_F(ModbusRegistersTest, ShowThePositionTheForceAndTheWatchdog) {
  joint.JumpEncoder(-2);
  EXPECT_THAT(Ask(modbus::ReadRegisters(100, 2)), ElementsAre(3, 4, 0xFF, 0xFF, 0xFF, 0xFE));
  EXPECT_THAT(Ask(modbus::ReadRegisters(400, 2)), ElementsAre(3, 4, 0, 50, 0, 1));
  EXPECT_THAT(Ask(modbus::ReadRegisters(300, 1)), ElementsAre(3, 2, 0, 6));
}

TEST_F(ModbusRegistersTest, EnableTheMotorAndTakeItsForce) {
  EXPECT_THAT(Put(300, 15), ElementsAre(16, 1, 44, 0, 1));
  EXPECT_THAT(Put(200, 0xFFFF), ElementsAre(16, 0, 200, 0, 1));
  EXPECT_EQ(joint.force_counts(), -1);
  const auto both = modbus::ReadWriteRegisters(200, 1, 200, std::array<uint16_t, 1>{7});
  EXPECT_THAT(Ask(both), ElementsAre(23, 2, 0, 7));
  Put(300, 6);
  EXPECT_EQ(joint.force_counts(), 0);
}

TEST_F(ModbusRegistersTest, AnswerExceptionsToWhatDoesNotExist) {
  EXPECT_THAT(Ask(modbus::ReadRegisters(101, 2)), ElementsAre(0x83, 2));
  EXPECT_THAT(Put(100, 1), ElementsAre(0x90, 2));
  EXPECT_THAT(registers.Answer(Bytes{3, 0, 100, 0, 0}, 1), ElementsAre(0x83, 3));
  EXPECT_THAT(registers.Answer(Bytes{1, 0, 100, 0, 1}, 1), ElementsAre(0x81, 1));
  EXPECT_THAT(registers.Answer(Bytes{16, 0, 200, 0, 1, 4, 0, 0}, 1), ElementsAre(0x90, 3));
}

TEST_F(ModbusRegistersTest, DoWrongOnDemand) {
  joint.JumpEncoder(1);
  faults.wrong_order = true;
  EXPECT_THAT(Ask(modbus::ReadRegisters(100, 2)), ElementsAre(3, 4, 0, 1, 0, 0));
  faults.exceptions = true;
  EXPECT_THAT(Ask(modbus::ReadRegisters(100, 2)), ElementsAre(0x83, 4));
  faults.silent = true;
  EXPECT_TRUE(Ask(modbus::ReadRegisters(100, 2)).empty());
}

TEST_F(ModbusRegistersTest, SurviveAnyBytes) {
  std::mt19937 random(3);
  for (int i = 0; i < 200'000; ++i) {
    Bytes request(random() % 20);
    for (uint8_t& byte : request) {
      byte = static_cast<uint8_t>(random());
    }
    if (!request.empty()) {
      constexpr std::array<uint8_t, 4> kFunctions{3, 6, 16, 23};
      request[0] = kFunctions.at(random() % kFunctions.size());
    }
    const Bytes answer = registers.Answer(request, 1);
    EXPECT_EQ(answer.empty(), request.empty());
    EXPECT_LE(answer.size(), modbus::kMaxPduBytes);
  }
}

}  // namespace
}  // namespace mwidth::device::emulator
