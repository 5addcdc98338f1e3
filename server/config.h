// The configuration file: what the server's axes are.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "server/config_drive.h"
#include "server/model/axis_kind.h"
#include "server/model/envelope.h"
#include "server/model/loop_parameters.h"
#include "server/render/hand_monitor_config.h"
#include "server/render/watch_config.h"

namespace mwidth::server {

struct LimitsConfig {
  double mass_min = 0;
  double mass_max = 0;
  double force = 0;
  /// Largest change of the force per second; none: any.
  std::optional<double> force_slew;
  double position_min = 0;
  double position_max = 0;
  double velocity = 0;
  int max_missed_ticks = 0;
};

struct RealtimeConfig {
  /// SCHED_FIFO priority, 1..98.
  int priority = 0;
  /// CPU that the loop is pinned to; none: any.
  std::optional<int> cpu;
  /// What is polled instead of slept through before each deadline; at most half a period.
  int spin_us = 0;
  /// The CPUs keep the idle states from which they wake slowly.
  bool allow_deep_idle = false;
};

struct AxisConfig {
  std::string name;
  model::AxisKind kind = model::AxisKind::kLinear;
  model::LoopParameters loop;
  double required_gain_margin_db = 0;
  /// Largest standard deviation of the force that the encoder's counts may cause; none: any.
  std::optional<double> force_noise_limit;
  /// Hands and devices that every admitted mass is stable with; none: exactly those of `loop`.
  std::optional<model::HandEnvelope> hand_envelope;
  std::optional<model::DeviceTolerance> device_tolerance;
  LimitsConfig limits;
  render::WatchConfig watch;
  render::HandMonitorConfig hand_monitor;
  RealtimeConfig realtime;
  DriveConfig drive;
};

struct SessionsConfig {
  /// Where sessions are recorded; made with the first one.
  std::filesystem::path folder;
  /// No session begins with less space left.
  int min_free_mb = 0;
  /// Samples of an axis that wait for a slow disk before some are lost.
  int queue_samples = 0;
};

struct Config {
  /// The file as it was read.
  std::string text;
  std::string listen;
  /// Most sample streams on one axis, and most samples queued for one of them.
  int max_streams = 0;
  int stream_queue_samples = 0;
  /// An idle-priority thread on each CPU keeps it from halting.
  bool keep_cpus_awake = false;
  SessionsConfig sessions;
  std::vector<AxisConfig> axes;
};

/// The CPUs that the axes' loops are pinned to, each once for every loop.
std::vector<int> PinnedCpus(const Config& config);

/// Reads a TOML file. Every key is documented in deploy/config; an unknown or missing key, a wrong type and a
/// number out of range throw ConfigError.
Config LoadConfig(const std::filesystem::path& file);

/// The file that `name_or_file` means: an existing path, or else a shipped configuration such as "paper".
/// Throws ConfigError naming the shipped ones.
std::filesystem::path FindConfig(const std::string& name_or_file);

}  // namespace mwidth::server
