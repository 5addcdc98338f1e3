#include "device/canopen/set_up.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/device/canopen/fake_node.h"

namespace mwidth::device::canopen {
namespace {

using ::testing::AllOf;
using testing::FakeBus;
using testing::FakeNode;
using testing::FakeNow;
using ::testing::HasSubstr;
using testing::kNode;
using testing::TestConfig;

class SetUpTest : public ::testing::Test {
 protected:
  SetUpTest() { FakeBus::lost = false; }
  void Run() { canopen::SetUp(bus, config, FakeNow); }
  std::string Error() {
    try {
      Run();
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "set up";
  }

  CanopenDriveConfig config = TestConfig();
  std::shared_ptr<FakeNode> node = std::make_shared<FakeNode>();
  FakeBus bus{node};
};

TEST_F(SetUpTest, TellsTheDriveWhatTheConfigurationSays) {
  config.quick_stop_option = 2;
  config.interpolation_period = 125;
  config.interpolation_exponent = -5;
  node->Set(kControlword, 0x0F);
  Run();
  EXPECT_EQ(node->nmt, NmtState::kOperational);
  EXPECT_EQ(node->Get(kControlword), 0U);
  EXPECT_EQ(node->Get(kModeOfOperation), 10U);
  EXPECT_EQ(node->Get(kRpdo1Identifier), 0x4000'0205U);
  EXPECT_EQ(node->Get(kRpdo1Type), 255U);
  EXPECT_EQ(node->Get(kRpdo1Count), 2U);
  EXPECT_EQ(node->Get({kRpdo1Mapping, 1, 4}), 0x6040'0010U);
  EXPECT_EQ(node->Get({kRpdo1Mapping, 2, 4}), 0x6071'0010U);
  EXPECT_EQ(node->Get(kTpdo1Identifier), 0x4000'0185U);
  EXPECT_EQ(node->Get(kTpdo1Type), 1U);
  EXPECT_EQ(node->Get(kTpdo1Count), 3U);
  EXPECT_EQ(node->Get({kTpdo1Mapping, 1, 4}), 0x6041'0010U);
  EXPECT_EQ(node->Get({kTpdo1Mapping, 2, 4}), 0x6064'0020U);
  EXPECT_EQ(node->Get({kTpdo1Mapping, 3, 4}), 0x6077'0010U);
  EXPECT_EQ(node->Get(kMaxTorque), 1500U);
  EXPECT_EQ(node->Get(kInterpolationPeriod), 125U);
  EXPECT_EQ(node->Get(kInterpolationExponent), 0xFBU);
  EXPECT_EQ(node->Get(kQuickStopOption), 2U);
  EXPECT_EQ(node->Get(kConnectionLossOption), 2U);
  EXPECT_EQ(node->Get(kConsumerHeartbeat), 0x7F'0032U);
  EXPECT_EQ(node->Get(kProducerHeartbeat), 50U);
}

TEST_F(SetUpTest, TakesTheForceAwayBeforeAnythingElse) {
  Run();
  EXPECT_EQ(node->heard.at(0), NmtFrame(NmtCommand::kEnterPreOperational, kNode));
  EXPECT_EQ(
      node->heard.at(1),
      (can::Frame{.identifier = kSdoRequest + kNode, .size = 8, .bytes = {0x2B, 0x40, 0x60, 0, 0, 0, 0, 0}}));
  EXPECT_EQ(node->heard.at(2), NmtFrame(NmtCommand::kResetCommunication, kNode));
  EXPECT_EQ(node->heard.back(), NmtFrame(NmtCommand::kStart, kNode));
}

TEST_F(SetUpTest, APdoDoesNotExistWhileItChanges) {
  Run();
  bool exists = true;
  for (const can::Frame& frame : node->heard) {
    const uint32_t index = Get(frame, 1, 2);
    if (frame.identifier != kSdoRequest + kNode || frame.bytes[0] == 0x40) {
      continue;
    }
    if (index == 0x1400 && frame.bytes[3] == 1) {
      exists = (Get(frame, 4, 4) & kPdoInvalid) == 0;
    }
    if (index == 0x1600) {
      EXPECT_FALSE(exists);
    }
  }
  EXPECT_TRUE(exists);
}

TEST_F(SetUpTest, LeavesNoOtherWayToTheMotorOpen) {
  for (const Object& object : {kRpdo2Identifier, kRpdo3Identifier, kRpdo4Identifier}) {
    node->Set(object, 0x300 + kNode);
  }
  node->Set(kTorqueOffset, 25);
  Run();
  for (const Object& object : {kRpdo2Identifier, kRpdo3Identifier, kRpdo4Identifier}) {
    EXPECT_NE(node->Get(object) & kPdoInvalid, 0U);
  }
  EXPECT_EQ(node->Get(kTorqueOffset), 0U);
}

TEST_F(SetUpTest, LeavesItToArmingWhereTheDriveKnowsNoWatchdog) {
  node->Remove(kConnectionLossOption);
  node->Refuse(kConsumerHeartbeat, 0x0601'0002);
  EXPECT_EQ(Error(), "set up");
}

TEST_F(SetUpTest, SaysWhichDriveAndWhatIsWrongWithIt) {
  node->deaf = true;
  EXPECT_THAT(Error(), AllOf(HasSubstr("CiA 402 drive, node 5 on fake: it does not answer for object 6040h"),
                             HasSubstr("bit rate")));
}

TEST_F(SetUpTest, RefusesWhatIsNoDrive) {
  node->Set(kDeviceType, 0x000F'0191);
  EXPECT_THAT(Error(), AllOf(HasSubstr("says profile 401, not 402"), HasSubstr("check the node number")));
}

TEST_F(SetUpTest, RefusesAnotherRatedTorqueThanConfigured) {
  for (const uint32_t wrong : {0U, 249U, 251U, 2500U, 0xFFFF'FFFFU}) {
    node->Set(kRatedTorque, wrong);
    EXPECT_THAT(Error(), AllOf(HasSubstr("rated torque (6076h)"), HasSubstr("torque.rated says 0.25")))
        << wrong;
  }
  node->Set(kRatedTorque, 1'000'499);
  config.rated_torque = 1000;
  EXPECT_EQ(Error(), "set up");
}

TEST_F(SetUpTest, RefusesADriveThatDoesNotGoIntoTorqueMode) {
  node->Refuse(kModeOfOperation, 0x0609'0030);
  EXPECT_THAT(Error(), HasSubstr("refuses object 6060h: invalid value for the parameter"));
  node->aborts.clear();
  node->sdo_answer = [this](const can::Frame& request) {
    can::Frame reply{.identifier = kSdoReply + kNode, .size = 8, .bytes = request.bytes};
    const bool upload = request.bytes[0] == 0x40;
    const uint32_t index = Get(request, 1, 2);
    reply.bytes[0] = static_cast<uint8_t>(!upload ? 0x60 : index == 0x1000 ? 0x43 : 0x4F);
    Put(reply, 4, 4, index == 0x1000 ? 402 : 8);
    return reply;
  };
  EXPECT_THAT(Error(), HasSubstr("does not go into cyclic synchronous torque mode"));
}

TEST_F(SetUpTest, RefusesAValueThatDoesNotStay) {
  config.max_torque_per_mille = 1500;
  node->sdo_answer = nullptr;
  node->Set({.index = kMaxTorque.index, .subindex = 0, .size = 1}, 0);
  EXPECT_THAT(Error(), HasSubstr("6072h has not the 2 bytes"));
  node->Set(kMaxTorque, 0);
  node->Refuse(kQuickStopOption, 0x0602'0000);
  EXPECT_THAT(Error(), HasSubstr("refuses object 605Ah"));
}

TEST_F(SetUpTest, NeedsABootUpAndAHeartbeat) {
  node->boots = false;
  EXPECT_THAT(Error(), HasSubstr("does not boot up"));
  node->boots = true;
  node->sends_heartbeats = false;
  EXPECT_THAT(Error(), HasSubstr("no heartbeat that says operational"));
}

}  // namespace
}  // namespace mwidth::device::canopen
