#include "server/render/loop_config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

#include "tests/server/render/axis.h"

namespace mwidth::render {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

struct BadConfig {
  const char* field;
  std::function<void(LoopConfig&)> spoil;
};

std::string RefusalOf(const LoopConfig& config, const device::DriveInfo& drive) {
  try {
    Checked(config, drive);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

class LoopConfigTest : public testing::TestWithParam<BadConfig> {};

TEST_P(LoopConfigTest, RefusesAFieldThatIsOutOfRangeByItsName) {
  LoopConfig config = TestConfig();
  EXPECT_EQ(RefusalOf(config, ScriptedDrive().info), "accepted");
  GetParam().spoil(config);
  EXPECT_THAT(RefusalOf(config, ScriptedDrive().info),
              AllOf(StartsWith(std::string(GetParam().field) + " is "), HasSubstr("allowed is")));
}

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

INSTANTIATE_TEST_SUITE_P(
    Fields, LoopConfigTest,
    testing::Values(BadConfig{"period_s", [](LoopConfig& c) { c.period_s = 0.9e-4; }},
                    BadConfig{"period_s", [](LoopConfig& c) { c.period_s = 1.1e-2; }},
                    BadConfig{"period_s", [](LoopConfig& c) { c.period_s = kNan; }},
                    BadConfig{"cutoff_hz", [](LoopConfig& c) { c.cutoff_hz = 0; }},
                    BadConfig{"cutoff_hz", [](LoopConfig& c) { c.cutoff_hz = 501; }},
                    BadConfig{"force_limit", [](LoopConfig& c) { c.force_limit = 0; }},
                    BadConfig{"force_limit", [](LoopConfig& c) { c.force_limit = kNan; }},
                    BadConfig{"position_min", [](LoopConfig& c) { c.position_min = kNan; }},
                    BadConfig{"position_max", [](LoopConfig& c) { c.position_max = c.position_min; }},
                    BadConfig{"velocity_limit", [](LoopConfig& c) { c.velocity_limit = kNan; }},
                    BadConfig{"max_missed_ticks", [](LoopConfig& c) { c.max_missed_ticks = 17; }},
                    BadConfig{"fault_ramp_s", [](LoopConfig& c) { c.fault_ramp_s = 0.051; }},
                    BadConfig{"force_slew_limit", [](LoopConfig& c) { c.force_slew_limit = 0.9; }},
                    BadConfig{"force_slew_limit", [](LoopConfig& c) { c.force_slew_limit = kNan; }},
                    BadConfig{"watch.window_s", [](LoopConfig& c) { c.watch.window_s = 0.09; }},
                    BadConfig{"watch.window_s", [](LoopConfig& c) { c.watch.window_s = 10.1; }},
                    BadConfig{"watch.saturation_s", [](LoopConfig& c) { c.watch.saturation_s = 1.1; }},
                    BadConfig{"watch.slew_s", [](LoopConfig& c) { c.watch.slew_s = -1; }},
                    BadConfig{"watch.gap_s", [](LoopConfig& c) { c.watch.gap_s = kNan; }},
                    BadConfig{"watch.late_s", [](LoopConfig& c) { c.watch.late_s = 2; }},
                    BadConfig{"watch.delay_limit_s", [](LoopConfig& c) { c.watch.delay_limit_s = 0.05; }},
                    BadConfig{"watch.max_consecutive_overruns",
                              [](LoopConfig& c) { c.watch.max_consecutive_overruns = 1001; }},
                    BadConfig{"watch.acceleration_limit",
                              [](LoopConfig& c) { c.watch.acceleration_limit = 0; }},
                    BadConfig{"watch.freeze_velocity", [](LoopConfig& c) { c.watch.freeze_velocity = 0; }},
                    BadConfig{"watch.freeze_s", [](LoopConfig& c) { c.watch.freeze_s = 0; }},
                    BadConfig{"priority", [](LoopConfig& c) { c.realtime.priority = 100; }}),
    [](const auto& spoiled) {
      std::string name = std::string(spoiled.param.field) + "_" + std::to_string(spoiled.index);
      std::replace(name.begin(), name.end(), '.', '_');
      return name;
    });

TEST(LoopConfigDriveTest, RefusesADriveWhoseQuantaOrCounterCannotBe) {
  device::DriveInfo drive = ScriptedDrive().info;
  drive.position_quantum = 0;
  EXPECT_THAT(RefusalOf(TestConfig(), drive), StartsWith("the drive's position_quantum is "));
  drive = ScriptedDrive().info;
  drive.force_quantum = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(RefusalOf(TestConfig(), drive), StartsWith("the drive's force_quantum is "));
  drive = ScriptedDrive().info;
  drive.position_bits = 65;
  EXPECT_THAT(RefusalOf(TestConfig(), drive), StartsWith("the drive's position_bits is "));
}

TEST(LoopConfigDriveTest, RefusesACounterThatCanTurnHalfAroundWithinTheLongestGap) {
  device::DriveInfo drive = ScriptedDrive().info;  // 1e-6 m a count.
  drive.position_bits = 18;                        // Half a turn is 0.131 m: 26 ticks at 5 m/s.
  LoopConfig config = TestConfig();
  config.max_missed_ticks = 11;  // 25 ticks.
  EXPECT_EQ(RefusalOf(config, drive), "accepted");
  config.max_missed_ticks = 12;
  EXPECT_THAT(RefusalOf(config, drive), HasSubstr("half around"));
}

}  // namespace
}  // namespace mwidth::render
