#include "device/canopen/canopen_drive.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <optional>
#include <random>
#include <thread>

#include "tests/device/canopen/fake_node.h"

namespace mwidth::device::canopen {
namespace {

using testing::FakeBus;
using testing::FakeNode;
using testing::FakeNow;
using testing::kNode;
using testing::kOwnNode;
using testing::kTickNs;
using testing::TestConfig;

class CanopenDriveTest : public ::testing::Test {
 protected:
  CanopenDriveTest() {
    testing::fake_now_ns = 1'000'000'000;
    FakeBus::lost = false;
    FakeBus::refuses = false;
    FakeBus::connects = 0;
  }
  void Make() {
    drive = std::make_unique<CanopenDrive>(config, std::make_unique<FakeBus>(node), FakeNow);
    begin_ns = FakeNow();
    tick = 0;
  }
  /// The next tick's reading, on time.
  Reading Read() {
    ++tick;
    testing::fake_now_ns = std::max(FakeNow() + 1, begin_ns + static_cast<int64_t>(tick) * kTickNs);
    return drive->Read(tick);
  }
  /// Asks until the drive is enabled, or not, for at most `ticks`.
  Enabling Arm(int ticks = 50) {
    Enabling enabling = Enabling::kPending;
    for (int i = 0; i < ticks && enabling == Enabling::kPending; ++i) {
      Read();
      enabling = drive->Enable();
    }
    return enabling;
  }
  void MakeArmed() {
    Make();
    ASSERT_EQ(Arm(), Enabling::kEnabled);
    ASSERT_TRUE(Read().ok);
  }

  CanopenDriveConfig config = TestConfig();
  std::shared_ptr<FakeNode> node = std::make_shared<FakeNode>();
  int64_t begin_ns = 1'000'000'000;
  uint64_t tick = 0;
  std::unique_ptr<CanopenDrive> drive;
};

TEST_F(CanopenDriveTest, ReadsPositionsAndWritesForcesInCounts) {
  MakeArmed();
  EXPECT_DOUBLE_EQ(drive->Info().position_quantum, 1e-4);
  EXPECT_DOUBLE_EQ(drive->Info().force_quantum, 0.01);
  EXPECT_EQ(drive->Info().position_bits, 32);
  EXPECT_FALSE(drive->Info().simulated);
  for (const int32_t position : {0, -123'456, INT32_MAX, INT32_MIN}) {
    node->position = position;
    const Reading reading = Read();
    EXPECT_TRUE(reading.ok);
    EXPECT_EQ(reading.position_counts, position);
    EXPECT_EQ(reading.trouble, DriveTrouble::kNone);
  }
  // The paper's force acts against the positive direction.
  EXPECT_TRUE(drive->Write(250));
  EXPECT_EQ(node->Torque(), -250);
}

TEST_F(CanopenDriveTest, CountsTheOtherWayWhereItIsReversed) {
  config.position_scale = -1e-4;
  config.torque_reversed = true;
  MakeArmed();
  node->position = 1000;
  EXPECT_EQ(Read().position_counts, -1000);
  EXPECT_TRUE(drive->Write(250));
  EXPECT_EQ(node->Torque(), 250);
}

TEST_F(CanopenDriveTest, ATickIsASyncAndACommand) {
  MakeArmed();
  drive->Write(1);
  for (int i = 0; i < 40; ++i) {
    node->heard.clear();
    Read();
    drive->Write(-7);
    const auto heartbeat = HeartbeatFrame(kOwnNode, NmtState::kOperational);
    const bool due = node->heard.front() == heartbeat;
    ASSERT_EQ(node->heard.size(), due ? 3U : 2U);
    EXPECT_EQ(node->heard[node->heard.size() - 2], SyncFrame());
    EXPECT_EQ(node->heard.back(), CommandFrame(kNode, {.controlword = 0x0F, .torque_per_mille = 7}));
  }
}

TEST_F(CanopenDriveTest, SendsAHeartbeatAsOftenAsConfiguredAndNoneWithoutTicks) {
  Make();
  Read();
  node->heartbeats_heard = 0;
  for (int i = 0; i < 200; ++i) {
    Read();
  }
  EXPECT_EQ(node->heartbeats_heard, 10);
  testing::fake_now_ns += 1'000'000'000;
  EXPECT_EQ(node->heartbeats_heard, 10);
}

TEST_F(CanopenDriveTest, IsArmedStepByStepWithoutAForce) {
  Make();
  EXPECT_FALSE(drive->Write(100));
  node->commands.clear();
  EXPECT_EQ(Arm(), Enabling::kEnabled);
  EXPECT_EQ(node->state, DriveState::kOperationEnabled);
  std::vector<uint16_t> controlwords;
  for (const can::Frame& command : node->commands) {
    controlwords.push_back(static_cast<uint16_t>(Get(command, 0, 2)));
    EXPECT_EQ(Get(command, 2, 2), 0U);
  }
  EXPECT_EQ(controlwords, (std::vector<uint16_t>{0x06, 0x07, 0x0F}));
}

TEST_F(CanopenDriveTest, OnSyncTheForceActsWithTheNextOne) {
  config.exchange = TickExchange::kOnSync;
  MakeArmed();
  EXPECT_EQ(node->Get(kRpdo1Type), kOnEverySync);
  EXPECT_TRUE(drive->Write(30));
  EXPECT_EQ(node->Torque(), 0);
  EXPECT_TRUE(Read().ok);
  EXPECT_EQ(node->Torque(), -30);
  drive->Disable();  // Now, not with a SYNC that may never come.
  EXPECT_EQ(node->state, DriveState::kSwitchOnDisabled);
  EXPECT_TRUE(Read().ok);
}

TEST_F(CanopenDriveTest, DisablesTheVoltageAndLetsNoForceThroughAnyMore) {
  MakeArmed();
  drive->Write(100);
  drive->Disable();
  EXPECT_EQ(node->state, DriveState::kSwitchOnDisabled);
  EXPECT_FALSE(drive->Write(100));
  EXPECT_EQ(node->Torque(), 0);
  EXPECT_EQ(Arm(), Enabling::kEnabled);
}

TEST_F(CanopenDriveTest, TakesTheForceAwayWhenItConnectsAndWhenItGoes) {
  node->nmt = NmtState::kOperational;
  node->state = DriveState::kOperationEnabled;
  node->Set(kControlword, 0x0F);
  Make();
  EXPECT_EQ(node->Get(kControlword), 0U);
  ASSERT_EQ(Arm(), Enabling::kEnabled);
  drive.reset();
  EXPECT_EQ(node->state, DriveState::kSwitchOnDisabled);
}

TEST_F(CanopenDriveTest, NeverExceedsTheTorqueThatTheDriveMayGive) {
  MakeArmed();
  EXPECT_TRUE(drive->Write(1500));
  EXPECT_FALSE(drive->Write(1501));
  EXPECT_FALSE(drive->Write(INT32_MIN));
  EXPECT_EQ(node->Torque(), -1500);
}

TEST_F(CanopenDriveTest, IsNotArmedWithoutAWatchdogThatReacts) {
  Make();
  const uint32_t consumer = node->Get(kConsumerHeartbeat);
  EXPECT_EQ(consumer, 0x7F'0032U);
  for (const uint32_t weak : {0U, 0x7F'0000U, 0x7F'0065U, 0x01'0032U}) {
    node->Set(kConsumerHeartbeat, weak);
    EXPECT_EQ(Arm(), Enabling::kNoWatchdog) << weak;
  }
  node->Set(kConsumerHeartbeat, 0x7F'0064);
  node->Set(kConnectionLossOption, 0);
  EXPECT_EQ(Arm(), Enabling::kNoWatchdog);
  EXPECT_EQ(node->state, DriveState::kSwitchOnDisabled);
  node->Set(kConnectionLossOption, 3);
  EXPECT_EQ(Arm(), Enabling::kEnabled);
}

TEST_F(CanopenDriveTest, IsArmedWithoutOneOnlyWhereThatIsConfigured) {
  node->Remove(kConnectionLossOption);
  Make();
  EXPECT_EQ(Arm(), Enabling::kNoWatchdog);
  drive.reset();
  config.without_watchdog = true;
  Make();
  EXPECT_EQ(Arm(), Enabling::kEnabled);
}

TEST_F(CanopenDriveTest, ResetsAFaultOnlyWhenItIsArmed) {
  node->state = DriveState::kFault;
  Make();
  for (int i = 0; i < 20; ++i) {
    Read();
  }
  EXPECT_EQ(node->state, DriveState::kFault);
  EXPECT_EQ(Arm(), Enabling::kEnabled);
}

TEST_F(CanopenDriveTest, GoesOnTryingWhereAFaultStays) {
  node->state = DriveState::kFault;
  node->fault_can_be_reset = false;
  Make();
  EXPECT_EQ(Arm(500), Enabling::kPending);
  drive->Disable();
  EXPECT_EQ(node->controlword, kDisableVoltage);
}

TEST_F(CanopenDriveTest, TellsOfAnEmergencyAndOfADriveThatStopsFollowing) {
  MakeArmed();
  node->Fault(0x2310);
  const Reading reading = Read();
  EXPECT_EQ(reading.trouble, DriveTrouble::kError);
  EXPECT_EQ(reading.trouble_code, 0x2310);
  EXPECT_TRUE(reading.ok);
  drive->Disable();
  EXPECT_EQ(Read().trouble, DriveTrouble::kNone);
  ASSERT_EQ(Arm(), Enabling::kEnabled);
  EXPECT_EQ(Read().trouble, DriveTrouble::kNone);
  for (const DriveState state : {DriveState::kSwitchOnDisabled, DriveState::kQuickStopActive,
                                 DriveState::kSwitchedOn, DriveState::kFault}) {
    node->state = state;
    EXPECT_EQ(Read().trouble, DriveTrouble::kError);
    EXPECT_EQ(Read().trouble_code, 0);
  }
}

TEST_F(CanopenDriveTest, SaysItAgainUntilTheDriveLetsGo) {
  MakeArmed();
  ASSERT_TRUE(drive->Write(100));
  node->obeys = false;
  drive->Disable();
  Read();
  const int heartbeats = node->heartbeats_heard;
  for (int i = 0; i < 100; ++i) {
    Read();
  }
  EXPECT_EQ(node->Torque(), -100);
  EXPECT_EQ(node->heartbeats_heard, heartbeats) << "they would keep its watchdog quiet";
  node->obeys = true;
  Read();
  EXPECT_EQ(node->Torque(), 0);
  for (int i = 0; i < 100; ++i) {
    Read();
  }
  EXPECT_GT(node->heartbeats_heard, heartbeats);
  node->commands.clear();
  Read();
  EXPECT_TRUE(node->commands.empty()) << "it has let go";
  EXPECT_EQ(Arm(), Enabling::kEnabled);
}

TEST_F(CanopenDriveTest, ForeignFramesRefuseArmingAndAreTroubleWhileEnabled) {
  for (const can::Frame& foreign :
       {SyncFrame(), CommandFrame(kNode, {.controlword = 0x0F, .torque_per_mille = 100}),
        HeartbeatFrame(kOwnNode, NmtState::kOperational), NmtFrame(NmtCommand::kStop, 0),
        can::Frame{.identifier = kRpdo2 + kNode, .size = 3},
        can::Frame{.identifier = kRpdo3 + kNode, .size = 6},
        can::Frame{.identifier = kRpdo4 + kNode, .size = 6},
        can::Frame{.identifier = kSdoRequest + kNode, .size = 8}}) {
    node = std::make_shared<FakeNode>();
    drive.reset();
    Make();
    node->Say(foreign);
    EXPECT_EQ(Arm(), Enabling::kForeignTraffic) << foreign.identifier;
    testing::fake_now_ns += 1'900'000'000;
    EXPECT_EQ(drive->Enable(), Enabling::kForeignTraffic);
    begin_ns = FakeNow();
    tick = 0;
    testing::fake_now_ns += 200'000'000;
    // So long without a tick, the heartbeats have come and are heard first.
    ASSERT_EQ(Arm(), Enabling::kEnabled);
    node->Say(foreign);
    const Reading reading = Read();
    EXPECT_EQ(reading.trouble, DriveTrouble::kForeignTraffic);
    EXPECT_EQ(reading.trouble_code, foreign.identifier);
  }
}

TEST_F(CanopenDriveTest, OthersOnTheBusAreNoBusinessOfOurs) {
  MakeArmed();
  for (const can::Frame& other :
       {CommandFrame(kNode + 1, {}), HeartbeatFrame(kOwnNode - 1, NmtState::kOperational),
        NmtFrame(NmtCommand::kStop, kNode + 1), can::Frame{.identifier = kEmergency + kNode + 1, .size = 8},
        can::Frame{.identifier = kTpdo1 + kNode, .remote = true, .size = 8},
        can::Frame{.identifier = kHeartbeat + kOwnNode, .remote = true, .size = 1}}) {
    node->Say(other);
  }
  const Reading reading = Read();
  EXPECT_TRUE(reading.ok);
  EXPECT_EQ(reading.trouble, DriveTrouble::kNone);
}

TEST_F(CanopenDriveTest, ALatePositionNeverPassesForAFreshOne) {
  MakeArmed();
  node->position = 111;
  node->answer_delay_ns = kTickNs + 300'000;
  EXPECT_FALSE(Read().ok);
  node->position = 222;
  node->answer_delay_ns = 50'000;
  // The late one comes first; where time is left, the tick asks anew.
  const Reading reading = Read();
  EXPECT_TRUE(reading.ok);
  EXPECT_EQ(reading.position_counts, 222);
  EXPECT_EQ(drive->counters().late_positions, 1);
  node->answer_delay_ns = 3 * kTickNs + 300'000;
  node->position = 333;
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(Read().ok) << i;
  }
  node->answer_delay_ns = 50'000;
  node->position = 444;
  const Reading next = Read();
  EXPECT_TRUE(!next.ok || next.position_counts == 444);
}

TEST_F(CanopenDriveTest, APositionThatNobodyAskedForIsNone) {
  MakeArmed();
  can::Frame unasked{.identifier = kTpdo1 + kNode, .size = 8};
  Put(unasked, 0, 2, 0x1237);
  Put(unasked, 2, 4, 999);
  node->Say(unasked);
  EXPECT_EQ(Read().position_counts, 0);
  EXPECT_EQ(drive->counters().late_positions, 1);
}

TEST_F(CanopenDriveTest, FramesOfAWrongLengthAreNone) {
  MakeArmed();
  node->feedback_bytes = 7;
  EXPECT_FALSE(Read().ok);
  node->feedback_bytes = 8;
  node->Say({.identifier = kEmergency + kNode, .size = 2, .bytes = {0x10, 0x23}});
  node->Say({.identifier = kHeartbeat + kNode, .size = 2, .bytes = {0, 0}});
  Read();
  Read();
  EXPECT_EQ(Read().trouble, DriveTrouble::kNone);
  EXPECT_EQ(drive->counters().malformed, 3);
}

TEST_F(CanopenDriveTest, ASilentDriveIsSilentAndComesBack) {
  MakeArmed();
  node->answers_sync = false;
  for (int i = 0; i < 6; ++i) {
    EXPECT_FALSE(Read().ok);
  }
  drive->Disable();
  EXPECT_EQ(Arm(), Enabling::kSilent);
  node->answers_sync = true;
  for (int i = 0; i < 3; ++i) {
    Read();
  }
  EXPECT_TRUE(Read().ok);
  EXPECT_EQ(Arm(), Enabling::kEnabled);
  EXPECT_EQ(FakeBus::connects, 1);
}

TEST_F(CanopenDriveTest, ArmingBearsAnAnswerThatIsMissing) {
  Make();
  Read();
  EXPECT_EQ(drive->Enable(), Enabling::kPending);
  node->answers_sync = false;
  Read();
  EXPECT_EQ(drive->Enable(), Enabling::kPending);
  node->answers_sync = true;
  EXPECT_EQ(Arm(), Enabling::kEnabled);
}

TEST_F(CanopenDriveTest, SdosThatNobodyAnswersAreSilence) {
  Make();
  node->sdo_answer = [](const can::Frame& /*request*/) { return can::Frame{.identifier = 0x7FF}; };
  EXPECT_EQ(Arm(300), Enabling::kSilent);
}

class LostDriveTest : public CanopenDriveTest {
 protected:
  void ExpectComesBackDisabled() {
    EXPECT_FALSE(Read().ok);
    EXPECT_FALSE(drive->Write(100));
    EXPECT_EQ(drive->Enable(), Enabling::kSilent);
    FakeBus::refuses = false;
    while (!drive->Read(++tick).ok) {
      std::this_thread::yield();
    }
    EXPECT_EQ(FakeBus::connects, 2);
    EXPECT_FALSE(drive->Write(100));
    EXPECT_EQ(node->Torque(), 0);
    begin_ns = FakeNow();
    tick = 0;
    EXPECT_EQ(Arm(), Enabling::kEnabled);
  }
};

TEST_F(LostDriveTest, ALostBusComesBackDisabled) {
  MakeArmed();
  drive->Write(100);
  FakeBus::refuses = true;
  FakeBus::lost = true;
  ExpectComesBackDisabled();
}

TEST_F(LostDriveTest, ADriveThatBootsAnewIsSetUpAnew) {
  MakeArmed();
  node->state = DriveState::kSwitchOnDisabled;
  FakeBus::refuses = true;
  node->BootUp();
  Read();
  ExpectComesBackDisabled();
}

TEST_F(LostDriveTest, ADriveWithoutHeartbeatsIsGone) {
  MakeArmed();
  node->sends_heartbeats = false;
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(Read().ok);
  }
  FakeBus::refuses = true;
  for (int i = 0; i < 51; ++i) {
    Read();
  }
  EXPECT_EQ(node->state, DriveState::kSwitchOnDisabled);
  node->sends_heartbeats = true;
  ExpectComesBackDisabled();
}

class NoisyBusTest : public CanopenDriveTest {
 protected:
  can::Frame AnyFrame() {
    constexpr std::array<uint16_t, 10> kIdentifiers{0x000, 0x080, 0x085, 0x185, 0x205,
                                                    0x585, 0x605, 0x705, 0x77F, 0x123};
    can::Frame frame{.identifier = kIdentifiers[random() % kIdentifiers.size()],
                     .remote = random() % 8 == 0,
                     .size = static_cast<uint8_t>(random() % 9)};
    for (uint8_t at = 0; at < frame.size && !frame.remote; ++at) {
      frame.bytes[at] = static_cast<uint8_t>(random());
    }
    return frame;
  }
  /// Whatever came, a torque is one that was written, within its limit, and with the drive enabled.
  void CheckCommands(std::size_t from, std::optional<int32_t> written) const {
    for (std::size_t i = from; i < node->commands.size(); ++i) {
      const auto controlword = static_cast<uint16_t>(Get(node->commands[i], 0, 2));
      const auto torque = static_cast<int16_t>(Get(node->commands[i], 2, 2));
      ASSERT_TRUE(torque == 0 || (controlword == kEnableOperation && torque == -written.value()));
      ASSERT_LE(std::abs(torque), 1500);
    }
  }

  std::mt19937 random{20120711};
};

TEST_F(NoisyBusTest, NoBytesFromTheBusMoveTheMotorOrBreakTheLoop) {
  int taken = 0;
  int troubles = 0;
  for (int episode = 0; episode < 2000; ++episode) {
    drive.reset();
    node = std::make_shared<FakeNode>();
    FakeBus::refuses = false;
    MakeArmed();
    FakeBus::refuses = true;  // A drive that is lost stays so for the episode.
    for (int i = 0; i < 20; ++i) {
      node->Say(AnyFrame(), random() % 1'000'000);
      const std::size_t before = node->commands.size();
      if (Read().trouble != DriveTrouble::kNone) {
        ++troubles;
        drive->Disable();
        drive->Enable();
      }
      const auto force = static_cast<int32_t>(random() % 4001) - 2000;
      const bool written = drive->Write(force);
      taken += written ? 1 : 0;
      CheckCommands(before, written ? std::optional(force) : std::nullopt);
    }
  }
  EXPECT_GT(taken, 1000);
  EXPECT_GT(troubles, 100);
}

}  // namespace
}  // namespace mwidth::device::canopen
