#include "device/canopen/arming.h"

#include <gtest/gtest.h>

#include "device/canopen/cia402.h"
#include "tests/device/canopen/fake_node.h"

namespace mwidth::device::canopen {
namespace {

using testing::kNode;
using testing::TestConfig;

constexpr uint16_t kSwitchOnDisabledWord = 0x250;
constexpr uint16_t kOperationEnabledWord = 0x1237;

can::Frame Answer(const Object& object, uint32_t value) {
  can::Frame frame = DownloadRequest(kNode, object, value);
  frame.identifier = kSdoReply + kNode;
  frame.bytes[0] = static_cast<uint8_t>(0x43 | (4 - object.size) << 2);
  return frame;
}

class ArmingTest : public ::testing::Test {
 protected:
  Arming::Step Next(uint16_t statusword = kSwitchOnDisabledWord) { return arming.Next(statusword, ++now_ns); }
  /// Answers both questions about the watchdog.
  void ReadWatchdog() {
    Next();
    arming.Hear(Answer(kConsumerHeartbeat, 0x7F'0032));
    Next();
    arming.Hear(Answer(kConnectionLossOption, 2));
    Next();
  }

  CanopenDriveConfig config = TestConfig();
  Arming arming{config};
  int64_t now_ns = 0;
};

TEST_F(ArmingTest, AsksForTheWatchdogBeforeItMovesAnything) {
  Arming::Step step = Next();
  EXPECT_EQ(step.request, UploadRequest(kNode, kConsumerHeartbeat));
  EXPECT_FALSE(step.controlword);
  EXPECT_FALSE(Next().request) << "asked twice";
  arming.Hear(Answer(kConsumerHeartbeat, 0x7F'0032));
  step = Next();
  EXPECT_EQ(step.request, UploadRequest(kNode, kConnectionLossOption));
  arming.Hear(Answer(kConnectionLossOption, 1));
  EXPECT_EQ(Next().enabling, Enabling::kPending);
  EXPECT_EQ(Next().controlword, kShutdown);
}

TEST_F(ArmingTest, WalksTheStatesAndEndsWhereTheDriveFollowsItsOwnWord) {
  ReadWatchdog();
  EXPECT_EQ(Next(0x218).controlword, kFaultReset);
  EXPECT_EQ(Next(0x250).controlword, kShutdown);
  EXPECT_EQ(Next(0x231).controlword, kSwitchOn);
  EXPECT_EQ(Next(0x233).controlword, kEnableOperation);
  const Arming::Step last = Next(kOperationEnabledWord);
  EXPECT_EQ(last.enabling, Enabling::kEnabled);
  EXPECT_FALSE(last.controlword);
}

TEST_F(ArmingTest, ADriveThatSomebodyElseEnabledIsToldFirst) {
  ReadWatchdog();
  const Arming::Step step = Next(kOperationEnabledWord);
  EXPECT_EQ(step.enabling, Enabling::kPending);
  EXPECT_EQ(step.controlword, kEnableOperation);
  EXPECT_EQ(Next(kOperationEnabledWord).enabling, Enabling::kEnabled);
}

TEST_F(ArmingTest, AnAbortOrAnotherWidthIsNoWatchdog) {
  can::Frame abort = Answer(kConsumerHeartbeat, 0x0602'0000);
  abort.bytes[0] = 0x80;
  can::Frame narrow = Answer(kConsumerHeartbeat, 0x7F'0032);
  narrow.bytes[0] = 0x4B;
  for (const can::Frame& reply : {abort, narrow}) {
    Next();
    arming.Hear(reply);
    EXPECT_EQ(Next().enabling, Enabling::kNoWatchdog);
    EXPECT_FALSE(arming.under_way());
  }
}

TEST_F(ArmingTest, AnAnswerToSomethingElseChangesNothing) {
  arming.Hear(Answer(kConsumerHeartbeat, 0x7F'0032));  // Before it was asked for.
  Next();
  arming.Hear(Answer(kConnectionLossOption, 2));
  EXPECT_EQ(Next().enabling, Enabling::kPending);
  arming.Hear(Answer(kConsumerHeartbeat, 0x7F'0032));
  arming.Hear(Answer(kMaxTorque, 2));
  EXPECT_EQ(Next().request, UploadRequest(kNode, kConnectionLossOption));
}

TEST_F(ArmingTest, WaitsAQuarterOfASecondForAnAnswer) {
  Next();
  now_ns += 249'000'000;
  EXPECT_EQ(Next().enabling, Enabling::kPending);
  now_ns += 2'000'000;
  EXPECT_EQ(Next().enabling, Enabling::kSilent);
}

TEST_F(ArmingTest, BeginsAnewAfterAReset) {
  ReadWatchdog();
  Next();
  arming.Reset();
  EXPECT_EQ(Next().request, UploadRequest(kNode, kConsumerHeartbeat));
}

TEST_F(ArmingTest, WithoutAWatchdogItWalksAtOnce) {
  config.without_watchdog = true;
  EXPECT_EQ(Next().controlword, kShutdown);
}

}  // namespace
}  // namespace mwidth::device::canopen
