#include "device/canopen/survey.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "tests/device/canopen/fake_node.h"

namespace mwidth::device::canopen {
namespace {

using testing::FakeBus;
using testing::FakeNode;
using testing::FakeNow;
using ::testing::HasSubstr;
using testing::kNode;
using testing::TestConfig;

class SurveyTest : public ::testing::Test {
 protected:
  SurveyTest() {
    FakeBus::lost = false;
    node->Set(kSupportedModes, 0x0000'03A5);
    node->Set(kStatusword, 0x0250);
    node->Set(kErrorCode, 0);
    node->Set(kPosition, static_cast<uint32_t>(-2000));
  }
  std::map<std::string, SurveyFinding> Find() {
    std::map<std::string, SurveyFinding> found;
    for (SurveyFinding& finding : SurveyOn(bus, config, model::AxisKind::kRotary, FakeNow)) {
      found[finding.subject] = finding;
    }
    return found;
  }

  CanopenDriveConfig config = TestConfig();
  std::shared_ptr<FakeNode> node = std::make_shared<FakeNode>();
  FakeBus bus{node};
};

TEST_F(SurveyTest, TellsWhatItSeesAndWritesNothing) {
  auto found = Find();
  EXPECT_EQ(found["device"].seen, "profile 402 (1000h)");
  EXPECT_EQ(found["state"].seen, "switch on disabled");
  EXPECT_EQ(found["mode"].seen, "cyclic synchronous torque is known (6502h)");
  EXPECT_EQ(found["position"].seen, "-0.2 rad (-2000 in 6064h)");
  EXPECT_EQ(found["rated torque"].seen, "0.25 N m (250 in 6076h)");
  EXPECT_THAT(found["watchdog"].seen, HasSubstr("1016h"));
  for (const auto& [subject, finding] : found) {
    EXPECT_EQ(finding.advice, "") << subject;
  }
  for (const can::Frame& frame : node->heard) {
    EXPECT_EQ(frame.identifier, kSdoRequest + kNode);
    EXPECT_EQ(frame.bytes[0], 0x40) << "not an upload";
  }
}

TEST_F(SurveyTest, GivesAdviceWhereTheDriveCannotBeArmed) {
  node->Set(kDeviceType, 401);
  node->Set(kStatusword, 0x0237);
  node->Set(kErrorCode, 0xFF10);
  node->Set(kSupportedModes, 0x25);
  node->Set(kRatedTorque, 500);
  node->Remove(kConnectionLossOption);
  auto found = Find();
  EXPECT_THAT(found["device"].advice, HasSubstr("check axis.drive.node"));
  EXPECT_EQ(found["state"].seen, "operation enabled, error code FF10h");
  EXPECT_THAT(found["state"].advice, HasSubstr("Something enabled the motor"));
  EXPECT_THAT(found["mode"].advice, HasSubstr("Only a drive that has this mode"));
  EXPECT_THAT(found["rated torque"].advice, HasSubstr("axis.drive.torque.rated differs"));
  EXPECT_THAT(found["watchdog"].seen, HasSubstr("refuses object 6007h"));
  EXPECT_THAT(found["watchdog"].advice, HasSubstr("without_watchdog"));
  config.without_watchdog = true;
  EXPECT_EQ(Find()["watchdog"].advice, "");
}

TEST_F(SurveyTest, AsksASilentDriveOnce) {
  node->deaf = true;
  const SurveyReport report = SurveyOn(bus, config, model::AxisKind::kLinear, FakeNow);
  ASSERT_EQ(report.size(), 1U);
  EXPECT_THAT(report[0].seen, HasSubstr("does not answer"));
  EXPECT_NE(report[0].advice, "");
  EXPECT_EQ(node->heard.size(), 1U);
}

TEST_F(SurveyTest, ADriveMayLeaveOutWhichModesItKnows) {
  node->Remove(kSupportedModes);
  EXPECT_EQ(Find()["mode"].advice, "");
}

}  // namespace
}  // namespace mwidth::device::canopen
