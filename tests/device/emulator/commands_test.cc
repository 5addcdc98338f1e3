#include "device/emulator/commands.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <string_view>

#include "tests/device/emulator/still_joint.h"

namespace mwidth::device::emulator {
namespace {

/// Has every fault but dribbling, and remembers the error that it was told to have.
class ScriptedLink final : public Link {
 public:
  std::string Where() const override { return "here"; }
  bool Has(std::string_view fault) const override { return fault != "dribble"; }
  void Fail(uint16_t code) override { error_code = code; }

  uint16_t error_code = 0;
};

class CommandsTest : public ::testing::Test {
 protected:
  bool Say(const char* line) { return Answer(line) == "ok"; }
  std::string Answer(const char* line) { return Obey(line, faults, joint, link); }

  ScriptedLink link;

  LinkFaults faults;
  Joint joint{StillJoint(), std::make_unique<StillHand>()};
};

TEST_F(CommandsTest, SetEachFaultAndTakeItAway) {
  EXPECT_TRUE(Say("silence"));
  EXPECT_TRUE(faults.silent);
  EXPECT_TRUE(Say("exceptions"));
  EXPECT_TRUE(faults.exceptions);
  EXPECT_TRUE(Say("wrong-order"));
  EXPECT_TRUE(faults.wrong_order);
  EXPECT_TRUE(Say("delay 0.005"));
  EXPECT_EQ(faults.delay_ns, 5'000'000);
  EXPECT_TRUE(Say("heartbeat-loss"));
  EXPECT_TRUE(faults.heartbeat_lost);
  EXPECT_TRUE(Say("jump -30"));
  EXPECT_EQ(joint.PositionCounts(1), -30);
  EXPECT_TRUE(Say("freeze"));
  EXPECT_TRUE(Say("jump 30"));
  EXPECT_EQ(joint.PositionCounts(2), -30);
  EXPECT_TRUE(Say("well"));
  EXPECT_FALSE(faults.silent || faults.exceptions || faults.wrong_order || faults.heartbeat_lost);
  EXPECT_EQ(faults.delay_ns, 0);
  EXPECT_EQ(joint.PositionCounts(3), 0);
}

TEST_F(CommandsTest, TellTheState) {
  EXPECT_EQ(Answer("state"), "disabled, force 0 counts, watchdog fired 0 times");
  joint.SetEnabled(1, true);
  joint.SetForce(1, -7);
  EXPECT_EQ(Answer("state"), "enabled, force -7 counts, watchdog fired 0 times");
  joint.Trip(2, 0.05);
  EXPECT_EQ(Answer("state"), "disabled, force 0 counts, watchdog fired 1 times");
}

TEST_F(CommandsTest, MakeTheDriveFail) {
  EXPECT_TRUE(Say("emcy 2310"));
  EXPECT_EQ(link.error_code, 0x2310);
  EXPECT_TRUE(Say("abort"));
  EXPECT_TRUE(faults.exceptions);
}

TEST_F(CommandsTest, AreRefusedWhereTheLinkCannotHaveTheFault) {
  EXPECT_FALSE(Say("dribble 0.001"));
  EXPECT_EQ(faults.dribble_ns, 0);
}

TEST_F(CommandsTest, AreRefusedWhereTheyMeanNothing) {
  for (const char* line : {"", "silent", "delay", "delay x", "delay -1", "delay 1e9", "delay nan", "jump",
                           "jump up", "emcy", "emcy 0", "emcy 10000", "emcy error"}) {
    EXPECT_FALSE(Say(line)) << line;
  }
  EXPECT_EQ(faults.delay_ns, 0);
}

}  // namespace
}  // namespace mwidth::device::emulator
