// mwidthd: the server. Reads the configuration, wires the axes, serves them, and ends on a signal.

#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "server/axis.h"
#include "server/config.h"
#include "server/doctor_command.h"
#include "server/drive_address.h"
#include "server/record/session/session_store.h"
#include "server/render/wakeful_cpus.h"
#include "server/rpc/axis_registry.h"
#include "server/rpc/server.h"

namespace {

namespace record = mwidth::record;
namespace render = mwidth::render;
namespace rpc = mwidth::rpc;
namespace server = mwidth::server;

constexpr int kExitFailure = 1;
constexpr int kExitUsage = 2;
constexpr double kFastestSimulation = 1000;
// What requests that are under way get to finish.
constexpr std::chrono::milliseconds kPatience{500};

struct CommandLine {
  bool doctor = false;
  bool json = false;
  std::string root = "/";
  std::string config = "paper";
  std::string listen;
  std::string hand_motion;
  std::optional<int> reach;
  std::string drive;
  std::string sessions;
  server::AxisOptions axis;
};

CommandLine Parse(CLI::App& app, int argc, char** argv) {
  CommandLine line;
  app.add_option("--config", line.config,
                 "Configuration: a TOML file, or the name of a shipped one (paper, elbow)")
      ->capture_default_str();
  app.add_option("--listen", line.listen,
                 "HOST:PORT to serve gRPC on instead of the configuration's; port 0: any free one");
  app.add_option(
      "--hand-motion", line.hand_motion,
      "CSV recording that moves the simulated hand: columns time_s and one position, ending in _rad or _m");
  app.add_option("--reach", line.reach, "Play only this reach of the recording, from 1")
      ->check(CLI::PositiveNumber)
      ->needs("--hand-motion");
  app.add_option(
      "--drive", line.drive,
      "Where the drive is, instead of where the configuration has it: HOST:PORT, a serial device, or "
      "a CAN interface");
  app.add_option("--sessions", line.sessions, "Folder of recorded sessions, instead of the configuration's");
  app.add_option(
         "--simulation-speed", line.axis.simulation_speed,
         "Run the simulation in lock step with its clock, at most this many times as fast as real time: no "
         "deadline is ever missed")
      ->check(CLI::Range(0.01, kFastestSimulation));
  app.add_flag("--allow-non-realtime", line.axis.allow_non_realtime,
               "Render on a real drive even where the host refuses real-time scheduling");
  CLI::App* doctor = app.add_subcommand(
      "doctor",
      "Examine this host: is it fit for the configuration's loops, and what to change. Exit code 1 "
      "where a loop would be refused what it needs");
  doctor->fallthrough();
  doctor->add_flag("--json", line.json, "Answer with JSON");
  doctor->add_option("--root", line.root, "Examine the copy of a host's /proc, /sys and /dev in this folder")
      ->check(CLI::ExistingDirectory);
  app.set_version_flag("--version", MWIDTH_VERSION);
  app.parse(argc, argv);
  line.doctor = doctor->parsed();
  return line;
}

server::Config Load(const CommandLine& line) {
  server::Config config = server::LoadConfig(server::FindConfig(line.config));
  if (!line.listen.empty()) {
    config.listen = line.listen;
  }
  if (!line.sessions.empty()) {
    config.sessions.folder = line.sessions;
  }
  if (!line.hand_motion.empty()) {
    if (config.axes.size() != 1) {
      throw server::ConfigError(
          "--hand-motion: the configuration has several axes; set axis.drive.hand_motion.file");
    }
    auto* motion = std::get_if<server::HandMotionConfig>(&config.axes[0].drive.behind);
    if (motion == nullptr) {
      throw server::ConfigError("--hand-motion: the axis has a real drive, which nobody but a hand moves");
    }
    motion->file = line.hand_motion;
    motion->reach = line.reach;
  }
  if (!line.drive.empty()) {
    if (config.axes.size() != 1) {
      throw server::ConfigError("--drive: the configuration has several axes; set axis.drive of each");
    }
    server::PlaceDrive(line.drive, config.axes[0]);
  }
  return config;
}

// Before the axes begin and until they have ended, where it is asked for; a refusal is told to each of them.
std::unique_ptr<render::WakefulCpus> KeepCpusAwake(const server::Config& config,
                                                   server::AxisOptions& options) {
  if (!config.keep_cpus_awake) {
    return nullptr;
  }
  auto awake = std::make_unique<render::WakefulCpus>(server::PinnedCpus(config));
  options.host_refusal = awake->refusal();
  return awake;
}

std::string Joined(int argc, char** argv) {
  std::string joined;
  for (int i = 1; i < argc; ++i) {
    joined += (joined.empty() ? "" : " ") + std::string(argv[i]);
  }
  return joined;
}

// Sessions of a server that died are closed, and told. A folder that cannot be read keeps nobody from
// rendering.
void RecoverSessions(record::SessionStore& store) try {
  for (const record::StoredSession& session : store.RecoverAll()) {
    std::cerr << "session " << session.id << ": "
              << (session.problem.empty() ? "recovered; its server died before it ended" : session.problem)
              << '\n';
  }
} catch (const std::filesystem::filesystem_error& error) {
  std::cerr << "sessions cannot be recovered: " << error.what() << '\n';
}

void Serve(const server::Config& config, const std::vector<std::unique_ptr<server::Axis>>& axes,
           rpc::Recording recording, const sigset_t& ending) {
  rpc::AxisRegistry registry;
  for (const auto& axis : axes) {
    registry.Add(axis->Served());
    std::cerr << "axis " << axis->description().name << ": " << axis->description().realtime_message << '\n';
  }
  rpc::Server server(registry, config.listen, MWIDTH_VERSION, std::move(recording));
  std::cout << "listening on " << server.address() << std::endl;
  int signal = 0;
  sigwait(&ending, &signal);
  std::cerr << "ending on signal " << signal << '\n';
  // A person may be held by all of them: none renders on while another ramps down.
  for (const auto& axis : axes) {
    axis->BeginStop();
  }
  for (const auto& axis : axes) {
    axis->Stop();
  }
  server.Shutdown(kPatience);
}

// The whole program, but for failures.
int Run(int argc, char** argv, const sigset_t& ending) {
  CLI::App app{"mwidthd " MWIDTH_VERSION ": renders virtual masses on robot joints, and only stable ones"};
  try {
    CommandLine line = Parse(app, argc, argv);
    const server::Config config = Load(line);
    if (line.doctor) {
      return server::RunDoctor(config, line.root, line.json);
    }
    const auto awake = KeepCpusAwake(config, line.axis);
    constexpr uint64_t kBytesPerMb = 1'000'000;
    record::SessionStore store(config.sessions.folder,
                               kBytesPerMb * static_cast<uint64_t>(config.sessions.min_free_mb));
    RecoverSessions(store);
    std::vector<std::unique_ptr<server::Axis>> axes;
    for (const server::AxisConfig& axis : config.axes) {
      axes.push_back(std::make_unique<server::Axis>(axis, config, line.axis, store));
    }
    Serve(config, axes,
          {.store = store,
           .provenance = {.software_version = MWIDTH_VERSION,
                          .configuration = config.text,
                          .command_line = Joined(argc, argv),
                          .axis_state = {}}},
          ending);
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kExitUsage;
  } catch (const server::ConfigError& error) {
    std::cerr << "mwidthd: " << error.what() << '\n';
    return kExitUsage;
  } catch (const std::invalid_argument& error) {
    std::cerr << "mwidthd: " << error.what() << '\n';
    return kExitUsage;
  }
}

}  // namespace

int main(int argc, char** argv) {
  // Every later thread inherits the mask: these signals reach nobody but the sigwait above.
  sigset_t ending;
  sigemptyset(&ending);
  sigaddset(&ending, SIGTERM);
  sigaddset(&ending, SIGINT);
  pthread_sigmask(SIG_BLOCK, &ending, nullptr);
  try {
    return Run(argc, argv, ending);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "mwidthd: %s\n", error.what());
    return kExitFailure;
  }
}
