#include "server/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

namespace mwidth::server {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string ReadFile(const std::filesystem::path& file) {
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

class ConfigTest : public testing::Test {
 protected:
  /// What LoadConfig says of the shipped configuration with `from` replaced by `to`.
  static std::string ErrorAfter(const std::string& from, const std::string& to) {
    std::string text = ReadFile(CONFIG_DIR "/paper.toml");
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    const std::filesystem::path file =
        testing::TempDir() + testing::UnitTest::GetInstance()->current_test_info()->name() + ".toml";
    std::ofstream(file) << text;
    try {
      LoadConfig(file);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "accepted";
  }
};

TEST_F(ConfigTest, ReadsThePaperLoop) {
  const Config config = LoadConfig(CONFIG_DIR "/paper.toml");
  ASSERT_EQ(config.axes.size(), 1U);
  const AxisConfig& axis = config.axes[0];
  EXPECT_EQ(axis.kind, model::AxisKind::kLinear);
  EXPECT_EQ(axis.loop.device_mass, 0.070);
  EXPECT_EQ(axis.loop.device_damping, 0.005);
  EXPECT_EQ(axis.loop.hand_stiffness, 700);
  EXPECT_EQ(axis.loop.hand_damping, 5);
  EXPECT_EQ(axis.loop.period_s, 0.001);
  EXPECT_EQ(axis.loop.estimator, model::EstimatorKind::kFilteredDifference);
  EXPECT_EQ(axis.loop.cutoff_hz, 10);
  EXPECT_EQ(axis.loop.delay_s, 0);
}

TEST_F(ConfigTest, ReadsTheLimitOnForceNoiseWhereThereIsOne) {
  EXPECT_FALSE(LoadConfig(CONFIG_DIR "/paper.toml").axes[0].force_noise_limit.has_value());
  const std::filesystem::path file = testing::TempDir() + "force_noise_limit.toml";
  std::string text = ReadFile(CONFIG_DIR "/paper.toml");
  const std::string commented = "# force_noise_limit = ";
  text.replace(text.find(commented), commented.size(), "force_noise_limit = ");
  std::ofstream(file) << text;
  EXPECT_EQ(LoadConfig(file).axes[0].force_noise_limit, 0.05);
  EXPECT_THAT(ErrorAfter("# force_noise_limit = 0.05", "force_noise_limit = 0"),
              AllOf(HasSubstr("axis.gate.force_noise_limit is 0"), HasSubstr("above 0")));
}

TEST_F(ConfigTest, ReadsTheEnvelopeAroundTheLoopsOwnValues) {
  std::string text = ReadFile(CONFIG_DIR "/paper.toml");
  for (const std::string line : {"[axis.envelope]", "stiffness = [",
                                 "include_released_hand =", "[axis.tolerance]", "damping = [0.003"}) {
    text.replace(text.find("# " + line), line.size() + 2, line);
  }
  const std::filesystem::path file = testing::TempDir() + "envelope.toml";
  std::ofstream(file) << text;
  const AxisConfig axis = LoadConfig(file).axes[0];
  using Range = model::ParameterRange;
  ASSERT_TRUE(axis.hand_envelope.has_value());
  EXPECT_EQ(axis.hand_envelope->hand_stiffness, (Range{100, 2000}));
  EXPECT_EQ(axis.hand_envelope->hand_damping, (Range{5, 5}));
  EXPECT_EQ(axis.hand_envelope->hand_mass, (Range{0, 0}));
  EXPECT_TRUE(axis.hand_envelope->include_released_hand);
  ASSERT_TRUE(axis.device_tolerance.has_value());
  EXPECT_EQ(axis.device_tolerance->device_mass, (Range{0.07, 0.07}));
  EXPECT_EQ(axis.device_tolerance->device_damping, (Range{0.003, 0.01}));
  const AxisConfig without = LoadConfig(CONFIG_DIR "/paper.toml").axes[0];
  EXPECT_FALSE(without.hand_envelope.has_value());
  EXPECT_FALSE(without.device_tolerance.has_value());
}

TEST_F(ConfigTest, RefusesAnEnvelopeThatIsNoneOrHasNotTheLoopItself) {
  const auto with = [](const std::string& table) { return table + "\n[axis.gate]"; };
  EXPECT_THAT(ErrorAfter("[axis.gate]", with("[axis.envelope]\nstiffness = [800, 2000]")),
              AllOf(HasSubstr("axis.envelope.stiffness"), HasSubstr("own value, 700")));
  EXPECT_THAT(ErrorAfter("[axis.gate]", with("[axis.envelope]\ndamping = [20, 2]")),
              HasSubstr("its first number must not be above its second"));
  EXPECT_THAT(ErrorAfter("[axis.gate]", with("[axis.envelope]\ndamping = [-1, 20]")),
              HasSubstr("axis.envelope.damping is -1"));
  EXPECT_THAT(ErrorAfter("[axis.gate]", with("[axis.envelope]\ndamping = 5")),
              HasSubstr("allowed is [min, max]"));
  EXPECT_THAT(ErrorAfter("[axis.gate]", with("[axis.envelope]\ninclude_released_hand = 1")),
              HasSubstr("true or false"));
  EXPECT_THAT(ErrorAfter("[axis.gate]", with("[axis.tolerance]\nstiffness = [1, 2]")),
              HasSubstr("allowed are damping, mass"));
  EXPECT_THAT(ErrorAfter("[axis.gate]", with("[axis.tolerance]\nmass = [0, 1]")),
              HasSubstr("axis.tolerance.mass"));
}

TEST_F(ConfigTest, ReadsWhatIsAssumedOfTheHandThatIsWatched) {
  const std::string shipped = ReadFile(CONFIG_DIR "/paper.toml");
  const auto read = [](const std::string& text) {
    const std::filesystem::path file = testing::TempDir() + "hand_monitor.toml";
    std::ofstream(file) << text;
    return LoadConfig(file).axes[0].hand_monitor;
  };
  const render::HandMonitorConfig monitor = read(shipped);
  EXPECT_TRUE(monitor.enabled);
  EXPECT_EQ(monitor.device_mass, 0.07);
  EXPECT_EQ(monitor.device_damping, 0.005);
  EXPECT_EQ(monitor.least_damping, 5.005);
  EXPECT_EQ(monitor.max_unexplained, render::HandMonitorConfig{}.max_unexplained);

  const std::string tables =
      "[axis.envelope]\ndamping = [2, 20]\n[axis.tolerance]\nmass = [0.06, 0.08]\ndamping = [0.003, 0.01]\n";
  const std::string table = "[axis.hand_monitor]";
  std::string text = shipped;
  text.insert(text.find(table), tables);
  const std::string enabled = "enabled = true";
  text.replace(text.find(enabled), enabled.size(), "enabled = false");
  const render::HandMonitorConfig with_envelope = read(text);
  EXPECT_FALSE(with_envelope.enabled);
  EXPECT_EQ(with_envelope.device_mass, 0.06);
  EXPECT_EQ(with_envelope.device_damping, 0.003);
  EXPECT_EQ(with_envelope.least_damping, 2.003);

  const std::string without =
      shipped.substr(0, shipped.find(table)) + shipped.substr(shipped.find("[axis.realtime]"));
  EXPECT_EQ(read(without).least_damping, 5.005);
  EXPECT_EQ(read(without).min_swing, monitor.min_swing);
  for (const auto& [key, refused] :
       {std::pair{"min_swing = 0.05", "min_swing = 0"}, std::pair{"min_growth = 1.02", "min_growth = 0.9"},
        std::pair{"max_unexplained = 0.006", "max_unexplained = 0.2"},
        std::pair{"max_push = 0.1", "max_push = -1"},
        std::pair{"max_energy_ratio = 1.2", "max_energy_ratio = 0.5"},
        std::pair{"energy_swing = 0.4", "energy_swing = 3"}}) {
    EXPECT_THAT(ErrorAfter(key, refused), HasSubstr("axis.hand_monitor."));
  }
}

TEST_F(ConfigTest, ReadsWhatIsAskedOfTheHost) {
  const Config shipped = LoadConfig(CONFIG_DIR "/paper.toml");
  EXPECT_FALSE(shipped.keep_cpus_awake);
  EXPECT_EQ(shipped.axes[0].realtime.priority, 80);
  EXPECT_EQ(shipped.axes[0].realtime.spin_us, 0);
  EXPECT_FALSE(shipped.axes[0].realtime.allow_deep_idle);
  EXPECT_TRUE(PinnedCpus(shipped).empty());

  std::string text = ReadFile(CONFIG_DIR "/paper.toml");
  for (const auto& [from, to] : {std::pair{"keep_cpus_awake = false", "keep_cpus_awake = true"},
                                 std::pair{"# cpu = 1", "cpu = 1"}, std::pair{"spin_us = 0", "spin_us = 500"},
                                 std::pair{"allow_deep_idle = false", "allow_deep_idle = true"}}) {
    text.replace(text.find(from), std::string(from).size(), to);
  }
  const std::filesystem::path file = testing::TempDir() + "host.toml";
  std::ofstream(file) << text;
  const Config config = LoadConfig(file);
  EXPECT_TRUE(config.keep_cpus_awake);
  EXPECT_EQ(config.axes[0].realtime.spin_us, 500);
  EXPECT_TRUE(config.axes[0].realtime.allow_deep_idle);
  EXPECT_EQ(PinnedCpus(config), std::vector<int>{1});
}

TEST_F(ConfigTest, LetsALoopPollHalfItsPeriodAtMost) {
  EXPECT_THAT(ErrorAfter("spin_us = 0", "spin_us = 501"),
              AllOf(HasSubstr("axis.realtime.spin_us is 501"), HasSubstr("0 to 500")));
  EXPECT_THAT(ErrorAfter("spin_us = 0", "spin_us = -1"), HasSubstr("axis.realtime.spin_us is -1"));
}

TEST_F(ConfigTest, ReadsEveryShippedConfiguration) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(CONFIG_DIR)) {
    EXPECT_NO_THROW(LoadConfig(entry.path())) << entry.path();
    ++count;
  }
  EXPECT_GE(count, 2);
}

TEST_F(ConfigTest, NamesFileLineKeyAndRangeOfAWrongNumber) {
  EXPECT_THAT(ErrorAfter("cutoff_hz = 10.0", "cutoff_hz = 501"),
              AllOf(HasSubstr(".toml:42: axis.loop.cutoff_hz is 501"), HasSubstr("at most 500")));
  EXPECT_THAT(ErrorAfter("period_s = 0.001", "period_s = 0"), HasSubstr("from 0.0001 to 0.01"));
  EXPECT_THAT(ErrorAfter("mass = 0.070", "mass = nan"), HasSubstr("axis.device.mass is nan"));
  EXPECT_THAT(ErrorAfter("stiffness = 700.0", "stiffness = inf"), HasSubstr("axis.hand.stiffness is inf"));
}

TEST_F(ConfigTest, ReadsTheEstimatorAndItsCutoffs) {
  const std::string text = ReadFile(CONFIG_DIR "/paper.toml");
  const std::string last = "cutoff_hz = 10.0";
  const std::size_t begin = text.find("estimator = ");
  const std::string shipped = text.substr(begin, text.find(last) + last.size() - begin);
  const auto with = [&shipped](const std::string& estimator, const std::string& cutoff_hz) {
    return ErrorAfter(shipped, "estimator = \"" + estimator + "\"\ncutoff_hz = " + cutoff_hz);
  };
  for (const model::EstimatorKind kind : model::kEstimatorKinds) {
    EXPECT_EQ(with(model::Name(kind), "30"), "accepted");
  }
  EXPECT_EQ(with("kalman", "500"), "accepted");
  EXPECT_THAT(with("butterworth", "495"),
              AllOf(HasSubstr("axis.loop.cutoff_hz is 495"), HasSubstr("to 490")));
  EXPECT_THAT(with("filtered-accelerometer", "30"),
              AllOf(HasSubstr(".toml:40: axis.loop.estimator is \"filtered-accelerometer\""),
                    HasSubstr("[axis.drive.accelerometer]")));
  EXPECT_THAT(with("savitzky-golay", "30"), AllOf(HasSubstr("axis.loop.estimator is \"savitzky-golay\""),
                                                  HasSubstr("\"butterworth\", \"kalman\"")));
  EXPECT_EQ(ErrorAfter(shipped, last), "accepted");
}

TEST_F(ConfigTest, ReadsTheAccelerometerOfTheSimulatedDrive) {
  EXPECT_EQ(LoadConfig(CONFIG_DIR "/paper.toml").axes[0].drive.acceleration_quantum, 0);
  std::string text = ReadFile(CONFIG_DIR "/paper.toml");
  for (const std::string line : {"[axis.drive.accelerometer]", "bandwidth_hz =", "quantum = 0.01"}) {
    ASSERT_NE(text.find("# " + line), std::string::npos) << line;
    text.replace(text.find("# " + line), line.size() + 2, line);
  }
  const std::string shipped = "estimator = \"filtered-difference\"";
  text.replace(text.find(shipped), shipped.size(), "estimator = \"accelerometer\"");
  const std::filesystem::path file = testing::TempDir() + "accelerometer.toml";
  std::ofstream(file) << text;
  const AxisConfig axis = LoadConfig(file).axes[0];
  EXPECT_EQ(axis.loop.estimator, model::EstimatorKind::kAccelerometer);
  EXPECT_EQ(axis.loop.accelerometer_bandwidth_hz, 200);
  EXPECT_EQ(axis.drive.accelerometer_bandwidth_hz, 200);
  EXPECT_EQ(axis.drive.acceleration_quantum, 0.01);
}

TEST_F(ConfigTest, RefusesAnAccelerometerThatARealDriveDoesNotRead) {
  std::string text = ReadFile(CONFIG_DIR "/modbus.toml");
  const std::string own = "estimator = \"filtered-difference\"";
  const std::size_t at = text.find("[axis.loop]");
  ASSERT_NE(at, std::string::npos);
  const std::size_t stands = text.find(own, at);
  if (stands == std::string::npos) {
    text.insert(at + 11, "\nestimator = \"accelerometer\"");
  } else {
    text.replace(stands, own.size(), "estimator = \"accelerometer\"");
  }
  const std::filesystem::path file = testing::TempDir() + "modbus_accelerometer.toml";
  std::ofstream(file) << text;
  try {
    LoadConfig(file);
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("a drive of this type reads no accelerometer"));
  }
}

TEST_F(ConfigTest, ReadsWhereSessionsAreRecorded) {
  EXPECT_EQ(LoadConfig(CONFIG_DIR "/modbus.toml").sessions.folder, "mwidth-sessions");
  std::string text = ReadFile(CONFIG_DIR "/paper.toml");
  const std::string shipped = "min_free_mb = 200";
  text.replace(text.find(shipped), shipped.size(), "min_free_mb = 7");
  const std::filesystem::path file = testing::TempDir() + "sessions.toml";
  std::ofstream(file) << text;
  const Config config = LoadConfig(file);
  EXPECT_EQ(config.sessions.min_free_mb, 7);
  EXPECT_EQ(config.sessions.queue_samples, 100'000);
  EXPECT_EQ(config.text, text);
  EXPECT_THAT(ErrorAfter("min_free_mb = 200", "min_free_mb = 0"),
              HasSubstr("server.sessions.min_free_mb is 0"));
  EXPECT_THAT(ErrorAfter("folder = \"mwidth-sessions\"", "folder = \"\""),
              HasSubstr("server.sessions.folder is empty"));
}

TEST_F(ConfigTest, NamesAnUnknownKeyAndTheAllowedOnes) {
  EXPECT_THAT(ErrorAfter("cutoff_hz", "cutof_hz"), HasSubstr("axis.loop.cutoff_hz is missing"));
  EXPECT_THAT(
      ErrorAfter("delay_s = 0.0", "delay = 0.0"),
      AllOf(HasSubstr("axis.loop.delay is not a key"), HasSubstr("cutoff_hz, delay_s, estimator, period_s")));
}

TEST_F(ConfigTest, RefusesWrongTypesAndWords) {
  EXPECT_THAT(ErrorAfter("period_s = 0.001", "period_s = \"1 ms\""), HasSubstr("axis.loop.period_s is"));
  EXPECT_THAT(ErrorAfter("kind = \"linear\"", "kind = \"round\""), HasSubstr(R"(allowed are "linear")"));
  EXPECT_THAT(ErrorAfter("type = \"simulated\"", "type = \"real\""),
              HasSubstr(R"(allowed are "simulated", "modbus-tcp", "modbus-rtu")"));
  EXPECT_THAT(ErrorAfter("max_missed_ticks = 16", "max_missed_ticks = 2.5"), HasSubstr("a whole number"));
  EXPECT_THAT(ErrorAfter("[axis.device]", "[axis.devise]"), HasSubstr("axis.device is missing"));
  EXPECT_THAT(ErrorAfter("position_max = 0.25", "position_max = -1"), HasSubstr("above position_min"));
  EXPECT_THAT(ErrorAfter("force_quantum = 0.001", "force_quantum = 1e-12"), HasSubstr("too fine"));
}

TEST_F(ConfigTest, NamesTheLineOfASyntaxError) {
  EXPECT_THAT(ErrorAfter("kind = \"linear\"", "kind = linear"), HasSubstr(".toml:27"));
}

TEST_F(ConfigTest, RefusesAMissingFileByNamingTheShippedOnes) {
  EXPECT_THROW(FindConfig("no-such-configuration"), ConfigError);
  EXPECT_THROW(LoadConfig("no-such-file.toml"), ConfigError);
}

TEST_F(ConfigTest, DerivesWhatTheWatchesBearWhereTheFileDoesNotSayIt) {
  std::string text = ReadFile(CONFIG_DIR "/paper.toml");
  const std::size_t begin = text.find("[axis.watch]");
  text.erase(begin, text.find("[axis.realtime]") - begin);
  const std::filesystem::path file = testing::TempDir() + "no_watch.toml";
  std::ofstream(file) << text;
  const render::WatchConfig derived = LoadConfig(file).axes[0].watch;
  EXPECT_EQ(derived.window_s, 1);
  EXPECT_EQ(derived.saturation_s, 0.1);
  EXPECT_DOUBLE_EQ(derived.delay_limit_s, 0.00025);
  EXPECT_DOUBLE_EQ(derived.acceleration_limit, 5000);
  EXPECT_DOUBLE_EQ(derived.freeze_velocity, 0.1);
  const render::WatchConfig shipped = LoadConfig(CONFIG_DIR "/paper.toml").axes[0].watch;
  EXPECT_EQ(shipped.acceleration_limit, 1000);
  EXPECT_EQ(shipped.freeze_s, 0.1);
}

TEST_F(ConfigTest, AddsTheDelayThatIsCertifiedToTheToleranceOfTheWatch) {
  std::string text = ReadFile(CONFIG_DIR "/paper.toml");
  const std::string without = "delay_s = 0.0\n";
  text.replace(text.find(without), without.size(), "delay_s = 0.001\n");
  const std::filesystem::path file = testing::TempDir() + "delayed_watch.toml";
  std::ofstream(file) << text;
  EXPECT_DOUBLE_EQ(LoadConfig(file).axes[0].watch.delay_limit_s, 0.00125);
}

TEST_F(ConfigTest, RefusesWatchesAndSlewLimitsOutOfRange) {
  EXPECT_THAT(ErrorAfter("window_s = 1.0", "window_s = 0.01"), HasSubstr("axis.watch.window_s"));
  EXPECT_THAT(ErrorAfter("saturation_s = 0.1", "saturation_s = 1.5"),
              HasSubstr("axis.watch.saturation_s is 1.5; allowed is a number from 0 to 1"));
  EXPECT_THAT(ErrorAfter("delay_tolerance_s = 0.00025", "delay_tolerance_s = 0.002"),
              HasSubstr("axis.watch.delay_tolerance_s"));
  EXPECT_THAT(ErrorAfter("acceleration = 1000.0", "acceleration = 0.0"),
              HasSubstr("axis.watch.acceleration"));
  EXPECT_THAT(ErrorAfter("freeze_s = 0.1", "freezes = 0.1"), HasSubstr("axis.watch.freezes"));
  EXPECT_THAT(ErrorAfter("max_consecutive_overruns = 10", "max_consecutive_overruns = 1001"),
              HasSubstr("axis.watch.max_consecutive_overruns"));
  EXPECT_THAT(ErrorAfter("force_slew = 4000.0", "force_slew = 0.5"),
              AllOf(HasSubstr("axis.limits.force_slew"), HasSubstr("at least a force count")));
}

}  // namespace
}  // namespace mwidth::server
