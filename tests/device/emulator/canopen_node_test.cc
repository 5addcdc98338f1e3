#include "device/emulator/canopen_node.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "tests/device/emulator/still_joint.h"

namespace mwidth::device::emulator {
namespace {

using can::Frame;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr int64_t kMs = 1'000'000;

Frame FrameOf(uint16_t identifier, const std::vector<uint8_t>& bytes) {
  Frame frame{.identifier = identifier, .size = static_cast<uint8_t>(bytes.size())};
  std::copy(bytes.begin(), bytes.end(), frame.bytes.begin());
  return frame;
}

/// Node 5, whose master is node 127; time passes by the millisecond.
struct Rig {
  static canopen::CanopenDriveConfig Config() {
    canopen::CanopenDriveConfig config;
    config.node = 5;
    config.position_scale = 1e-4;
    config.rated_torque = 0.25;
    return config;
  }
  std::vector<Frame> Sent() { return std::exchange(sent, {}); }
  // Frames that the node sends while time passes.
  std::vector<Frame> Wait(int64_t ms) {
    for (int64_t i = 0; i < ms; ++i) {
      now += kMs;
      node.Turn(now);
    }
    return Sent();
  }
  // Its answers to a frame.
  std::vector<Frame> Say(uint16_t identifier, const std::vector<uint8_t>& bytes) {
    node.Receive(FrameOf(identifier, bytes), now);
    return Sent();
  }
  void Put(uint16_t index, uint8_t subindex, int64_t value, std::size_t size) {
    std::vector<uint8_t> request{static_cast<uint8_t>(0x23 | (4 - size) << 2),
                                 static_cast<uint8_t>(index & 0xFF), static_cast<uint8_t>(index >> 8),
                                 subindex};
    const std::vector<uint8_t> bytes = ToBytes(value, 4);
    request.insert(request.end(), bytes.begin(), bytes.end());
    const auto answers = Say(0x605, request);
    ASSERT_EQ(answers.size(), 1U);
    EXPECT_EQ(answers[0].identifier, 0x585);
    EXPECT_EQ(answers[0].bytes[0], 0x60) << std::hex << index;
  }
  int64_t Get(uint16_t index, uint8_t subindex = 0) {
    const auto answers = Say(0x605, {0x40, static_cast<uint8_t>(index & 0xFF),
                                     static_cast<uint8_t>(index >> 8), subindex, 0, 0, 0, 0});
    EXPECT_EQ(answers.size(), 1U);
    return answers.empty() ? 0 : FromBytes(answers[0].data().last(4), false);
  }
  void Beat() { Say(0x77F, {5}); }
  // Maps PDOs, sets heartbeats and the reaction, and starts.
  void Configure(uint8_t rpdo_type, int64_t reaction) {
    Wait(11);
    Put(0x1400, 1, 0x8000'0205, 4);
    Put(0x1400, 2, rpdo_type, 1);
    Put(0x1600, 0, 0, 1);
    Put(0x1600, 2, 0x6071'0010, 4);
    Put(0x1600, 0, 2, 1);
    Put(0x1400, 1, 0x205, 4);
    Put(0x1800, 1, 0x8000'0185, 4);
    Put(0x1A00, 0, 0, 1);
    Put(0x1A00, 2, 0x6064'0020, 4);
    Put(0x1A00, 3, 0x6077'0010, 4);
    Put(0x1A00, 0, 3, 1);
    Put(0x1800, 1, 0x185, 4);
    Put(0x6060, 0, 10, 1);
    Put(0x6007, 0, reaction, 2);
    Put(0x605A, 0, 0, 2);
    Put(0x1016, 1, 127 << 16 | 50, 4);
    Say(0, {1, 5});
    Beat();
  }
  // Operation enabled, with a torque of 100 thousandths.
  void Enable() {
    for (const uint8_t word : std::vector<uint8_t>{6, 7, 15}) {
      Say(0x205, {word, 0, 0, 0});
      Wait(4);
    }
    Say(0x205, {15, 0, 100, 0});
    ASSERT_TRUE(joint.enabled());
    Sent();
  }

  Joint joint{StillJoint(), std::make_unique<StillHand>()};
  LinkFaults faults;
  std::vector<Frame> sent;
  CanopenNode node{Config(), true, joint, faults, [this](const Frame& frame) { sent.push_back(frame); }};
  int64_t now = kMs;
};

class CanopenNodeTest : public ::testing::Test, protected Rig {};

TEST_F(CanopenNodeTest, BootsUpAfterAWhile) {
  EXPECT_THAT(Wait(10), IsEmpty());
  EXPECT_THAT(Wait(1), ElementsAre(FrameOf(0x705, {0})));
  EXPECT_THAT(Wait(100), IsEmpty());
}

TEST_F(CanopenNodeTest, IsADrive) {
  Wait(11);
  EXPECT_EQ(Get(0x1000), 0x0002'0192);
  EXPECT_EQ(Get(0x6076), 250);
  EXPECT_EQ(Get(0x6502), 0x200);
  joint.JumpEncoder(-7);
  EXPECT_EQ(Get(0x6064), 0xFFFF'FFF9);
}

TEST_F(CanopenNodeTest, ObeysNmtToItselfAndToEverybody) {
  Wait(11);
  Put(0x1017, 0, 20, 2);
  EXPECT_THAT(Wait(21), ElementsAre(FrameOf(0x705, {0x7F})));
  Say(0, {1, 4});
  EXPECT_THAT(Wait(20), ElementsAre(FrameOf(0x705, {0x7F})));
  Say(0, {1, 5});
  EXPECT_THAT(Wait(20), ElementsAre(FrameOf(0x705, {0x05})));
  Say(0, {2, 0});
  EXPECT_THAT(Wait(20), ElementsAre(FrameOf(0x705, {0x04})));
  EXPECT_THAT(Say(0x605, {0x40, 0, 0x10, 0, 0, 0, 0, 0}), IsEmpty());
  Say(0, {0x80, 5});
  EXPECT_THAT(Wait(20), ElementsAre(FrameOf(0x705, {0x7F})));
}

TEST_F(CanopenNodeTest, ForgetsItsCommunicationOnAReset) {
  Configure(255, 1);
  Put(0x1017, 0, 20, 2);
  Say(0, {0x82, 5});
  EXPECT_THAT(Say(0x605, {0x40, 0, 0x10, 0, 0, 0, 0, 0}), IsEmpty());
  EXPECT_THAT(Wait(100), ElementsAre(FrameOf(0x705, {0})));
  EXPECT_EQ(Get(0x1017), 0);
  EXPECT_EQ(Get(0x1016, 1), 0);
  EXPECT_EQ(Get(0x1A00, 0), 1);
  // The profile's objects stay, but for a reset of the whole node.
  EXPECT_EQ(Get(0x6060), 10);
  Say(0, {0x81, 5});
  Wait(11);
  EXPECT_EQ(Get(0x6060), 0);
}

TEST_F(CanopenNodeTest, AnswersSyncWhileItIsOperational) {
  Configure(255, 1);
  joint.JumpEncoder(0x0102);
  EXPECT_THAT(Say(0x080, {}), ElementsAre(FrameOf(0x185, {0x40, 0x02, 2, 1, 0, 0, 0, 0})));
  Put(0x1800, 2, 3, 1);
  EXPECT_THAT(Say(0x080, {}), IsEmpty());
  EXPECT_THAT(Say(0x080, {}), IsEmpty());
  EXPECT_EQ(Say(0x080, {}).size(), 1U);
  faults.wrong_order = true;
  Put(0x1800, 2, 1, 1);
  EXPECT_THAT(Say(0x080, {}), ElementsAre(FrameOf(0x185, {0x40, 0x02, 0, 0, 2, 1, 0, 0})));
  Say(0, {0x80, 5});
  EXPECT_THAT(Say(0x080, {}), IsEmpty());
}

TEST_F(CanopenNodeTest, FollowsTheTorqueWhileItIsEnabled) {
  Configure(255, 1);
  Say(0x205, {15, 0, 100, 0});
  EXPECT_FALSE(joint.enabled());
  Enable();
  EXPECT_EQ(joint.force_counts(), 100);
  EXPECT_EQ(Get(0x6077), 100);
  EXPECT_EQ(Get(0x6041) & 0x1FFF, 0x1237);
  Say(0x205, {15, 0, 0xFF, 0xFF});
  EXPECT_EQ(joint.force_counts(), -1);
  Say(0x205, {0, 0, 100, 0});
  EXPECT_FALSE(joint.enabled());
  EXPECT_EQ(Get(0x6077), 0);
}

TEST_F(CanopenNodeTest, GivesNoMoreThanItsMostTorque) {
  Configure(255, 1);
  Put(0x6072, 0, 60, 2);
  Enable();
  EXPECT_EQ(joint.force_counts(), 60);
  // Bit 11: limited.
  EXPECT_NE(Get(0x6041) & 0x0800, 0);
  Say(0x205, {15, 0, 0, 0x80});
  EXPECT_EQ(joint.force_counts(), -60);
}

TEST_F(CanopenNodeTest, GivesNoTorqueInAnotherMode) {
  Configure(255, 1);
  Put(0x6060, 0, 0, 1);
  Enable();
  EXPECT_EQ(joint.force_counts(), 0);
  EXPECT_EQ(Get(0x6041) & 0x1000, 0);
}

TEST_F(CanopenNodeTest, WaitsForSyncWithASynchronousPdo) {
  Configure(1, 1);
  for (const uint8_t word : std::vector<uint8_t>{6, 7, 15, 15}) {
    Say(0x205, {word, 0, 100, 0});
    Say(0x080, {});
    Wait(4);
  }
  EXPECT_EQ(joint.force_counts(), 100);
  Say(0x205, {15, 0, 50, 0});
  EXPECT_EQ(joint.force_counts(), 100);
  Say(0x080, {});
  EXPECT_EQ(joint.force_counts(), 50);
}

TEST_F(CanopenNodeTest, TellsOfAPdoThatIsTooShort) {
  Configure(255, 1);
  EXPECT_THAT(Say(0x205, {6, 0, 1}), ElementsAre(FrameOf(0x085, {0x10, 0x82, 0x11, 0, 0, 0, 0, 0})));
  EXPECT_THAT(Say(0x205, {6, 0, 0, 0}), ElementsAre(FrameOf(0x085, {0, 0, 0, 0, 0, 0, 0, 0})));
}

TEST_F(CanopenNodeTest, FailsWithAnEmergencyUntilItIsReset) {
  Configure(255, 1);
  Enable();
  node.Fail(0x2310, now);
  EXPECT_THAT(Sent(), ElementsAre(FrameOf(0x085, {0x10, 0x23, 0x01, 0, 0, 0, 0, 0})));
  EXPECT_FALSE(joint.enabled());
  EXPECT_EQ(Get(0x6041) & 0x4F, 0x08);
  EXPECT_EQ(Get(0x603F), 0x2310);
  EXPECT_EQ(Get(0x1001), 1);
  Say(0x205, {0, 0, 0, 0});
  Say(0x205, {0x80, 0, 0, 0});
  Beat();
  EXPECT_THAT(Wait(4), ElementsAre(FrameOf(0x085, {0, 0, 0, 0, 0, 0, 0, 0})));
  EXPECT_EQ(Get(0x603F), 0);
  Enable();
}

TEST_F(CanopenNodeTest, ReactsToItsMastersSilenceAsItWasTold) {
  Configure(255, 2);
  Enable();
  Wait(30);
  Beat();
  EXPECT_THAT(Wait(50), IsEmpty());
  EXPECT_TRUE(joint.enabled());
  EXPECT_THAT(Wait(1), ElementsAre(FrameOf(0x085, {0x30, 0x81, 0x11, 0, 0, 0, 0, 0})));
  EXPECT_FALSE(joint.enabled());
  EXPECT_EQ(joint.trips().count, 1);
  EXPECT_EQ(joint.trips().after_s, 0.05);
  EXPECT_EQ(Get(0x6041) & 0x4F, 0x40);
  // 1029h by default: pre-operational.
  EXPECT_THAT(Say(0x080, {}), IsEmpty());
  // Once; and it is well again when the master is back.
  EXPECT_THAT(Wait(200), IsEmpty());
  EXPECT_THAT(Say(0x77F, {5}), ElementsAre(FrameOf(0x085, {0, 0, 0, 0, 0, 0, 0, 0})));
}

TEST(CanopenNode, LetsGoOnItsTimeOutHoweverLateItLooks) {
  const auto position = [](int64_t first_look_ms) {
    Rig rig;
    rig.Configure(255, 2);
    rig.Enable();
    rig.Beat();
    const int64_t start = rig.now;
    rig.node.Turn(start + first_look_ms * kMs);
    EXPECT_FALSE(rig.joint.enabled());
    return rig.joint.PositionCounts(start + 150 * kMs);
  };
  EXPECT_EQ(position(51), position(150));
}

TEST_F(CanopenNodeTest, FailsOnItsMastersSilenceWhereItWasToldSo) {
  Configure(255, 1);
  Enable();
  EXPECT_THAT(Wait(60), Contains(FrameOf(0x085, {0x30, 0x81, 0x11, 0, 0, 0, 0, 0})));
  EXPECT_EQ(Get(0x6041) & 0x4F, 0x08);
  // The error outlives its reason, until the reset.
  EXPECT_THAT(Say(0x77F, {5}), IsEmpty());
}

TEST_F(CanopenNodeTest, KeepsItsTorqueWhereItWasToldToDoNothing) {
  Configure(255, 0);
  Enable();
  Wait(60);
  EXPECT_EQ(joint.force_counts(), 100);
  EXPECT_EQ(joint.trips().count, 0);
}

TEST_F(CanopenNodeTest, HearsNoOtherNodeThanItsMaster) {
  Configure(255, 3);
  Enable();
  for (int i = 0; i < 6; ++i) {
    Say(0x77E, {5});
    Wait(10);
  }
  EXPECT_FALSE(joint.enabled());
}

TEST_F(CanopenNodeTest, LosesItsTorqueWithTheBus) {
  Configure(255, 1);
  Enable();
  Say(0, {0x82, 0});
  EXPECT_FALSE(joint.enabled());
}

TEST_F(CanopenNodeTest, SendsNoHeartbeatsOnDemand) {
  Wait(11);
  Put(0x1017, 0, 20, 2);
  faults.heartbeat_lost = true;
  EXPECT_THAT(Wait(100), IsEmpty());
  faults.heartbeat_lost = false;
  EXPECT_THAT(Wait(20), Not(IsEmpty()));
}

TEST_F(CanopenNodeTest, AbortsSdosOnDemand) {
  Wait(11);
  faults.exceptions = true;
  EXPECT_THAT(Say(0x605, {0x40, 0, 0x10, 0, 0, 0, 0, 0}),
              ElementsAre(FrameOf(0x585, {0x80, 0, 0x10, 0, 0, 0, 0, 0x08})));
}

TEST_F(CanopenNodeTest, IgnoresRemoteFramesAndOtherNodes) {
  Configure(255, 1);
  node.Receive({.identifier = 0x185, .remote = true, .size = 8}, now);
  EXPECT_THAT(Sent(), IsEmpty());
  EXPECT_THAT(Say(0x606, {0x40, 0, 0x10, 0, 0, 0, 0, 0}), IsEmpty());
}

TEST_F(CanopenNodeTest, SurvivesAnyFramesAndGivesNoTorqueThatItMayNot) {
  std::mt19937 random(11);
  constexpr std::array<uint16_t, 8> kHeard{0x000, 0x080, 0x205, 0x605, 0x605, 0x605, 0x77F, 0x705};
  constexpr std::array<uint16_t, 12> kObjects{0x1016, 0x1017, 0x1400, 0x1600, 0x1800, 0x1A00,
                                              0x6007, 0x6040, 0x6060, 0x6071, 0x6072, 0x60C2};
  Configure(255, 1);
  for (int i = 0; i < 200'000; ++i) {
    Frame frame{.identifier = kHeard.at(random() % kHeard.size()),
                .size = static_cast<uint8_t>(random() % 9)};
    for (std::size_t n = 0; n < frame.size; ++n) {
      frame.bytes.at(n) = static_cast<uint8_t>(random() % 4 == 0 ? random() : random() % 16);
    }
    if (frame.identifier == 0x605 && frame.size == 8) {
      // A write of an object that exists, more often than not.
      const uint16_t index = kObjects.at(random() % kObjects.size());
      frame.bytes[0] = static_cast<uint8_t>(0x22 | (random() % 16) << 2);
      frame.bytes[1] = static_cast<uint8_t>(index & 0xFF);
      frame.bytes[2] = static_cast<uint8_t>(index >> 8);
      frame.bytes[3] = static_cast<uint8_t>(random() % 4);
    }
    node.Receive(frame, now += kMs / 4);
    for (const Frame& answer : Sent()) {
      EXPECT_LE(answer.identifier, can::kMaxIdentifier);
      EXPECT_LE(answer.size, can::kMaxFrameBytes);
    }
    EXPECT_LE(std::abs(joint.force_counts()), INT16_MAX);
    EXPECT_TRUE(joint.enabled() || joint.force_counts() == 0);
  }
}

TEST(CanopenNodeWithoutAWatchdog, HasNoObjectForOne) {
  Joint joint{StillJoint(), std::make_unique<StillHand>()};
  const LinkFaults faults;
  std::vector<Frame> sent;
  CanopenNode node({}, false, joint, faults, [&](const Frame& frame) { sent.push_back(frame); });
  node.Turn(1);
  node.Receive(FrameOf(0x601, {0x40, 0x16, 0x10, 1, 0, 0, 0, 0}), 20 * kMs);
  EXPECT_THAT(sent, Contains(FrameOf(0x581, {0x80, 0x16, 0x10, 1, 0, 0, 0x02, 0x06})));
}

TEST(ReversedCanopenNode, CountsAndTurnsTheOtherWay) {
  Joint joint{StillJoint(), std::make_unique<StillHand>()};
  const LinkFaults faults;
  canopen::CanopenDriveConfig config;
  config.position_scale = -1e-4;
  config.torque_reversed = true;
  ObjectDictionary objects;
  Cia402Drive drive(config, objects, joint);
  int64_t now = 1;
  const auto wait = [&] {
    for (int i = 0; i < 10; ++i) {
      now += kMs;
      drive.Turn(now);
    }
  };
  wait();
  objects.Write({0x6060, 0}, ToBytes(10, 1));
  for (const int64_t word : {6, 15}) {
    objects.Write({0x6040, 0}, ToBytes(word, 2));
    wait();
  }
  objects.Write({0x6071, 0}, ToBytes(30, 2));
  EXPECT_EQ(joint.force_counts(), -30);
  EXPECT_EQ(objects.Get({0x6077, 0}), 30);
  joint.JumpEncoder(1000 - joint.PositionCounts(now));
  EXPECT_EQ(objects.Get({0x6064, 0}), -1000);
}

}  // namespace
}  // namespace mwidth::device::emulator
