#include "server/config.h"

#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "device/can/bus.h"
#include "server/config_hand_monitor.h"
#include "server/config_limits.h"
#include "server/config_sessions.h"
#include "server/config_table.h"

namespace mwidth::server {
namespace {

constexpr double kDefaultGainMarginDb = 3;
constexpr int kDefaultPriority = 80;
constexpr int kDefaultMaxStreams = 64;
constexpr int kDefaultStreamQueueSamples = 20'000;
constexpr double kLargest = 1e6;

model::EstimatorKind ReadEstimator(ConfigTable& timing) {
  const char* const otherwise = model::Name(model::EstimatorKind::kFilteredDifference);
  std::vector<std::string> names;
  names.reserve(model::kEstimatorKinds.size() + model::kAccelerometerKinds.size());
  for (const model::EstimatorKind known : model::kEstimatorKinds) {
    names.emplace_back(model::Name(known));
  }
  for (const model::EstimatorKind known : model::kAccelerometerKinds) {
    names.emplace_back(model::Name(known));
  }
  return *model::EstimatorNamed(timing.OneOfOr("estimator", names, otherwise));
}

void RefuseMissingAccelerometer(ConfigTable& axis, const AxisConfig& read) {
  if (!model::IsAccelerometer(read.loop.estimator) || read.drive.acceleration_quantum > 0) {
    return;
  }
  axis.Table("loop").Refuse(
      "estimator", std::string("is \"") + model::Name(read.loop.estimator) + "\", but " +
                       (read.drive.simulated()
                            ? "the drive has no accelerometer: describe it in [axis.drive.accelerometer]"
                            : "a drive of this type reads no accelerometer, only the simulated one does") +
                       ", or use an estimator from positions");
}

model::LoopParameters ReadLoop(ConfigTable& axis) {
  model::LoopParameters loop;
  ConfigTable timing = axis.Table("loop");
  loop.period_s = timing.Number("period_s", {1e-4, 1e-2});
  loop.estimator = ReadEstimator(timing);
  const model::CutoffRange cutoffs = model::CutoffRangeOf(loop.estimator);
  loop.cutoff_hz = timing.Number(
      "cutoff_hz", {cutoffs.min / loop.period_s, cutoffs.max / loop.period_s, cutoffs.min == 0});
  loop.delay_s = timing.NumberOr("delay_s", {0, 3 * loop.period_s}, 0);
  timing.Finish();

  ConfigTable device = axis.Table("device");
  loop.device_mass = device.Number("mass", {1e-6, 1e4});
  loop.device_damping = device.Number("damping", {0, 1e4});
  device.Finish();

  ConfigTable hand = axis.Table("hand");
  loop.hand_mass = hand.NumberOr("mass", {0, 1e4}, 0);
  loop.hand_damping = hand.Number("damping", {0, 1e4});
  loop.hand_stiffness = hand.Number("stiffness", {0, kLargest});
  hand.Finish();
  return loop;
}

// A range around the loop's own value, which is the range where the key does not stand.
model::ParameterRange ReadRange(ConfigTable& table, std::string_view key, Range allowed, double own) {
  const std::optional<Range> range = table.OptionalRange(key, allowed);
  if (!range) {
    return {.min = own, .max = own};
  }
  if (own < range->min || own > range->max) {
    std::ostringstream text;
    text << "does not hold the axis's own value, " << own;
    table.Refuse(key, text.str());
  }
  return {.min = range->min, .max = range->max};
}

std::optional<model::HandEnvelope> ReadHandEnvelope(ConfigTable& axis, const model::LoopParameters& loop) {
  std::optional<ConfigTable> table = axis.OptionalTable("envelope");
  if (!table) {
    return std::nullopt;
  }
  const model::HandEnvelope envelope{
      .hand_stiffness = ReadRange(*table, "stiffness", {0, kLargest}, loop.hand_stiffness),
      .hand_damping = ReadRange(*table, "damping", {0, 1e4}, loop.hand_damping),
      .hand_mass = ReadRange(*table, "mass", {0, 1e4}, loop.hand_mass),
      .include_released_hand = table->BooleanOr("include_released_hand", false)};
  table->Finish();
  return envelope;
}

std::optional<model::DeviceTolerance> ReadDeviceTolerance(ConfigTable& axis,
                                                          const model::LoopParameters& loop) {
  std::optional<ConfigTable> table = axis.OptionalTable("tolerance");
  if (!table) {
    return std::nullopt;
  }
  const model::DeviceTolerance tolerance{
      .device_mass = ReadRange(*table, "mass", {1e-6, 1e4}, loop.device_mass),
      .device_damping = ReadRange(*table, "damping", {0, 1e4}, loop.device_damping)};
  table->Finish();
  return tolerance;
}

RealtimeConfig ReadRealtime(ConfigTable realtime, double period_s) {
  const RealtimeConfig read{
      .priority = realtime.IntegerOr("priority", {1, 98}, kDefaultPriority),
      .cpu = realtime.OptionalInteger("cpu", {0, 1023}),
      // The other half stays with the rest of the CPU's threads, and far from the kernel's throttling.
      .spin_us = realtime.IntegerOr("spin_us", {0, std::floor(0.5e6 * period_s)}, 0),
      .allow_deep_idle = realtime.BooleanOr("allow_deep_idle", false),
  };
  realtime.Finish();
  return read;
}

AxisConfig ReadAxis(ConfigTable axis, const std::filesystem::path& folder) {
  AxisConfig read;
  read.name = axis.String("name");
  if (read.name.empty()) {
    axis.Refuse("name", "is empty; give the axis a name");
  }
  const std::string kind = axis.String("kind");
  if (kind != "linear" && kind != "rotary") {
    axis.Refuse("kind",
                "is \"" + kind + R"("; allowed are "linear" (kg, m, N) and "rotary" (kg m^2, rad, N m))");
  }
  read.kind = kind == "linear" ? model::AxisKind::kLinear : model::AxisKind::kRotary;
  read.loop = ReadLoop(axis);
  read.hand_envelope = ReadHandEnvelope(axis, read.loop);
  read.device_tolerance = ReadDeviceTolerance(axis, read.loop);
  read.hand_monitor = ReadHandMonitor(axis, read);

  ConfigTable gate = axis.Table("gate");
  read.required_gain_margin_db = gate.NumberOr("required_gain_margin_db", {0, 40}, kDefaultGainMarginDb);
  read.force_noise_limit = gate.OptionalNumber("force_noise_limit", {0, kLargest, true});
  gate.Finish();

  ConfigTable limits = axis.Table("limits");
  read.limits = ReadLimits(limits);
  read.realtime = ReadRealtime(axis.Table("realtime"), read.loop.period_s);
  read.drive = ReadDrive(axis.Table("drive"), folder, read.loop, read.limits.force);
  RefuseMissingAccelerometer(axis, read);
  read.loop.accelerometer_bandwidth_hz = read.drive.accelerometer_bandwidth_hz;
  if (read.limits.force_slew.value_or(HUGE_VAL) * read.loop.period_s < read.drive.force_quantum) {
    limits.Refuse("force_slew", "is too small: it must be at least a force count per period");
  }
  read.watch = ReadWatch(axis, read);
  axis.Finish();
  return read;
}

std::string ReadText(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream || !text) {
    throw ConfigError(file.string() + ": cannot be read");
  }
  return text.str();
}

}  // namespace

Config LoadConfig(const std::filesystem::path& file) {
  Config config;
  config.text = ReadText(file);
  toml::table parsed;
  try {
    parsed = toml::parse(config.text, file.string());
  } catch (const toml::parse_error& error) {
    std::ostringstream text;
    text << file.string() << ":" << error.source().begin.line << ": " << error.description();
    throw ConfigError(text.str());
  }
  ConfigTable root(parsed, file, "");
  ConfigTable server = root.Table("server");
  config.listen = server.String("listen");
  config.max_streams = server.IntegerOr("max_streams", {1, 100'000}, kDefaultMaxStreams);
  config.stream_queue_samples =
      server.IntegerOr("stream_queue_samples", {1000, kLargest}, kDefaultStreamQueueSamples);
  config.keep_cpus_awake = server.BooleanOr("keep_cpus_awake", false);
  config.sessions = ReadSessions(server);
  server.Finish();

  std::set<std::string> names;
  std::set<std::string> buses;
  for (ConfigTable& axis : root.Tables("axis")) {
    config.axes.push_back(ReadAxis(axis, file.parent_path()));
    if (!names.insert(config.axes.back().name).second) {
      axis.Refuse("name", "stands twice: \"" + config.axes.back().name + "\"; names must differ");
    }
    const auto* canopen = std::get_if<device::canopen::CanopenDriveConfig>(&config.axes.back().drive.behind);
    if (canopen != nullptr && !buses.insert(device::can::NameOf(canopen->bus)).second) {
      axis.Refuse(
          "drive",
          "is on a CAN bus that an axis before it has: each sends SYNC, so each needs a bus of its own");
    }
  }
  root.Finish();
  return config;
}

std::vector<int> PinnedCpus(const Config& config) {
  std::vector<int> cpus;
  for (const AxisConfig& axis : config.axes) {
    if (axis.realtime.cpu) {
      cpus.push_back(*axis.realtime.cpu);
    }
  }
  return cpus;
}

std::filesystem::path FindConfig(const std::string& name_or_file) {
  namespace fs = std::filesystem;
  if (fs::is_regular_file(name_or_file)) {
    return name_or_file;
  }
  // Installed and in the build tree alike: bin/mwidthd beside share/mwidth/config.
  const fs::path shipped =
      fs::read_symlink("/proc/self/exe").parent_path().parent_path() / "share/mwidth/config";
  if (fs::is_regular_file(shipped / (name_or_file + ".toml"))) {
    return shipped / (name_or_file + ".toml");
  }
  std::string names;
  if (fs::is_directory(shipped)) {
    std::set<std::string> sorted;
    for (const auto& entry : fs::directory_iterator(shipped)) {
      sorted.insert(entry.path().stem().string());
    }
    for (const std::string& name : sorted) {
      names += (names.empty() ? "" : ", ") + name;
    }
  }
  throw ConfigError(name_or_file + ": no such file, and no shipped configuration of that name; shipped are " +
                    names);
}

}  // namespace mwidth::server
