#include "device/emulator/modbus_rtu_server.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <memory>
#include <vector>

#include "device/emulator/serial_line.h"
#include "tests/device/emulator/still_joint.h"

namespace mwidth::device::emulator {
namespace {

using ::testing::ElementsAre;
using Bytes = std::vector<uint8_t>;

/// Unit 9 on a pseudo-terminal whose other end the test holds.
class ModbusRtuServerTest : public ::testing::Test {
 protected:
  ~ModbusRtuServerTest() override { close(end); }

  void Send(const Bytes& bytes) {
    ASSERT_EQ(write(end, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  // What the server says, once that is `size` bytes: the kernel hands bytes on when it pleases.
  Bytes Received(std::size_t size) {
    Bytes answer;
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (answer.size() < size && std::chrono::steady_clock::now() < deadline) {
      context.run_for(std::chrono::milliseconds(1));
      Bytes part(1000);
      const ssize_t got = read(end, part.data(), part.size());
      answer.insert(answer.end(), part.begin(), part.begin() + std::max<ssize_t>(0, got));
    }
    return answer;
  }
  Bytes Ask(const Bytes& bytes, std::size_t answer_size = 7) {
    Send(bytes);
    return Received(answer_size);
  }
  // Sends what nobody answers, and lets a silence pass. An answer would come before the next one.
  void Say(const Bytes& bytes) {
    Send(bytes);
    context.run_for(std::chrono::milliseconds(50));
  }
  static modbus::ModbusDriveConfig Map() {
    using modbus::RegisterType;
    return {.link = {},
            .map = {.position = {.address = 100, .type = RegisterType::kInt16, .scale = 1e-4},
                    .force = {.address = 200, .type = RegisterType::kInt16, .scale = 0.01},
                    .enable = {},
                    .watchdog = {}},
            .position_quantum = 1e-4,
            .force_quantum = 0.01};
  }

  const Bytes read_position = RtuFrame(9, Bytes{3, 0, 100, 0, 1});
  const Bytes position_5 = RtuFrame(9, Bytes{3, 2, 0, 5});

  boost::asio::io_context context{1};
  Joint joint{StillJoint(), std::make_unique<StillHand>()};
  LinkFaults faults;
  ModbusRegisters registers{Map(), joint, faults};
  PseudoTerminal terminal{context};
  int end = open(terminal.path().c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
  ModbusRtuServer server{terminal.TakeLine(), 9, std::chrono::microseconds(1750), registers, faults};
};

TEST_F(ModbusRtuServerTest, AnswersItsUnit) {
  joint.JumpEncoder(5);
  EXPECT_EQ(Ask(read_position), position_5);
  EXPECT_EQ(Ask(read_position), position_5);
}

TEST_F(ModbusRtuServerTest, SaysNothingToOtherUnits) {
  joint.JumpEncoder(5);
  Say(RtuFrame(8, Bytes{3, 0, 100, 0, 1}));
  EXPECT_EQ(Ask(read_position), position_5);
}

TEST_F(ModbusRtuServerTest, ObeysAWriteToEverybodyWithoutAWord) {
  joint.JumpEncoder(5);
  Say(RtuFrame(0, Bytes{16, 0, 200, 0, 1, 2, 0, 7}));
  EXPECT_EQ(joint.force_counts(), 7);
  EXPECT_EQ(Ask(RtuFrame(9, Bytes{3, 0, 200, 0, 1})), RtuFrame(9, Bytes{3, 2, 0, 7}));
}

TEST_F(ModbusRtuServerTest, ReadsARequestThatComesInParts) {
  joint.JumpEncoder(5);
  for (const uint8_t byte : Bytes(read_position.begin(), read_position.end() - 1)) {
    Send({byte});
    context.poll();
  }
  EXPECT_EQ(Ask({read_position.back()}), position_5);
}

TEST_F(ModbusRtuServerTest, FindsTheNextRequestAfterNoiseAndASilence) {
  joint.JumpEncoder(5);
  Bytes wrong = read_position;
  wrong.back() ^= 1;
  for (const Bytes& noise : {Bytes{0xFF}, Bytes{9, 16, 0, 200, 0, 1, 250}, Bytes(1000, 0), wrong}) {
    Say(noise);
    EXPECT_EQ(Ask(read_position), position_5);
  }
}

TEST_F(ModbusRtuServerTest, AnswersAFunctionThatNobodyKnowsWithAnException) {
  EXPECT_EQ(Ask(RtuFrame(9, Bytes{43, 14, 1, 0}), 5), RtuFrame(9, Bytes{43 | 0x80, 1}));
}

TEST_F(ModbusRtuServerTest, AnswersOneRequestAfterTheOther) {
  joint.JumpEncoder(5);
  faults.delay_ns = 2'000'000;
  Bytes two = read_position;
  two.insert(two.end(), read_position.begin(), read_position.end());
  Bytes answers = position_5;
  answers.insert(answers.end(), position_5.begin(), position_5.end());
  EXPECT_EQ(Ask(two, answers.size()), answers);
}

TEST_F(ModbusRtuServerTest, DribblesOnDemand) {
  joint.JumpEncoder(5);
  faults.dribble_ns = 1'000'000;
  EXPECT_EQ(Ask(read_position), position_5);
  // The second byte would come when the test has long been over.
  faults.dribble_ns = 3'600'000'000'000;
  Send(read_position);
  EXPECT_THAT(Received(1), ElementsAre(9));
}

TEST_F(ModbusRtuServerTest, KeepsTheLineWhileNobodyElseHasIt) {
  joint.JumpEncoder(5);
  close(end);
  context.run_for(std::chrono::milliseconds(5));
  end = open(terminal.path().c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
  EXPECT_EQ(Ask(read_position), position_5);
}

TEST(RtuSilence, IsThreeAndAHalfCharactersOnSlowLines) {
  EXPECT_EQ(RtuSilence(9600).count(), 4010);
  EXPECT_EQ(RtuSilence(19'200).count(), 2005);
  EXPECT_EQ(RtuSilence(115'200).count(), 1750);
}

}  // namespace
}  // namespace mwidth::device::emulator
