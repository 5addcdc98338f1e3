#include "device/emulator/commands.h"

#include <gtest/gtest.h>

#include <memory>

namespace mwidth::device::emulator {
namespace {

class Still final : public HandMotion {
 public:
  double PositionAt(double /*time_s*/) const noexcept override { return 0; }
};

class CommandsTest : public ::testing::Test {
 protected:
  bool Say(const char* line) { return Obey(line, faults, joint) == "ok"; }

  LinkFaults faults;
  Joint joint{{.plant = {.device_mass = 0.2, .hand_damping = 1, .hand_stiffness = 25, .cutoff_hz = 10},
               .position_quantum = 1e-4,
               .force_quantum = 0.01},
              std::make_unique<Still>()};
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
  EXPECT_TRUE(Say("dribble 0.001"));
  EXPECT_EQ(faults.dribble_ns, 1'000'000);
  EXPECT_TRUE(Say("jump -30"));
  EXPECT_EQ(joint.PositionCounts(1), -30);
  EXPECT_TRUE(Say("freeze"));
  EXPECT_TRUE(Say("jump 30"));
  EXPECT_EQ(joint.PositionCounts(2), -30);
  EXPECT_TRUE(Say("well"));
  EXPECT_FALSE(faults.silent || faults.exceptions || faults.wrong_order);
  EXPECT_EQ(faults.delay_ns + faults.dribble_ns, 0);
  EXPECT_EQ(joint.PositionCounts(3), 0);
}

TEST_F(CommandsTest, TellTheState) {
  EXPECT_EQ(Obey("state", faults, joint), "disabled, force 0 counts, watchdog fired 0 times");
  joint.SetEnabled(1, true);
  joint.SetForce(1, -7);
  EXPECT_EQ(Obey("state", faults, joint), "enabled, force -7 counts, watchdog fired 0 times");
  joint.Trip(2, 0.05);
  EXPECT_EQ(Obey("state", faults, joint), "disabled, force 0 counts, watchdog fired 1 times");
}

TEST_F(CommandsTest, AreRefusedWhereTheyMeanNothing) {
  for (const char* line :
       {"", "silent", "delay", "delay x", "delay -1", "delay 1e9", "delay nan", "jump", "jump up"}) {
    EXPECT_FALSE(Say(line)) << line;
  }
  EXPECT_EQ(faults.delay_ns, 0);
}

}  // namespace
}  // namespace mwidth::device::emulator
