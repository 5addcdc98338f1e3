// mwidth-drive: a drive that is none. Speaks a real drive's protocol in front of a simulated joint and hand.
#include <sched.h>

#include <CLI/CLI.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>

#include "device/emulator/commands.h"
#include "device/emulator/faults.h"
#include "device/emulator/joint.h"
#include "device/emulator/link.h"
#include "device/hand_motion.h"
#include "server/config.h"

namespace {

namespace asio = boost::asio;
namespace device = mwidth::device;
namespace emulator = mwidth::device::emulator;
namespace server = mwidth::server;

constexpr int kExitFailure = 1;
constexpr int kExitUsage = 2;

struct CommandLine {
  std::string config = "modbus";
  std::string axis;
  emulator::LinkPlace place;
  std::string hand_motion;
  std::optional<int> reach;
  double watchdog_s = 0.05;
};

CommandLine Parse(CLI::App& app, int argc, char** argv) {
  CommandLine line;
  app.add_option("--config", line.config,
                 "The server's own configuration: the joint, the hand, the drive's registers or objects, and "
                 "the kind of its link are read from it")
      ->capture_default_str();
  app.add_option("--axis", line.axis, "Which of its axes; default: the first");
  app.add_option("--address", line.place.address, "Modbus TCP, socketcand: address to listen on")
      ->capture_default_str();
  app.add_option(
      "--port", line.place.port,
      "Modbus TCP, socketcand: port to listen on; 0 (default): any free one, which is printed. A CANopen "
      "drive is behind a gateway then, whichever bus the configuration names");
  auto* device =
      app.add_option("--device", line.place.device,
                     "Modbus RTU: serial port to answer on, whichever Modbus the configuration names");
  app.add_flag("--pty", line.place.pty,
               "Modbus RTU: answer on a pseudo-terminal; its other end, for the server, is printed")
      ->excludes(device);
  app.add_option("--hand-motion", line.hand_motion,
                 "CSV recording that moves the hand; default: reaches of 30 degrees");
  app.add_option("--reach", line.reach, "Play only this reach of the recording, from 1")
      ->needs("--hand-motion");
  app.add_option(
         "--watchdog", line.watchdog_s,
         "Seconds without a request after which a Modbus drive disables its motor; 0: the drive, of any "
         "kind, has no watchdog")
      ->check(CLI::Range(0.0, 60.0))
      ->capture_default_str();
  app.footer(emulator::kCommandsHelp);
  app.set_version_flag("--version", MWIDTH_VERSION);
  app.parse(argc, argv);
  return line;
}

server::AxisConfig FindAxis(const CommandLine& line) {
  const server::Config config = server::LoadConfig(server::FindConfig(line.config));
  for (const server::AxisConfig& axis : config.axes) {
    if (line.axis.empty() || axis.name == line.axis) {
      return axis;
    }
  }
  throw server::ConfigError(line.config + ": no axis is called \"" + line.axis + "\"");
}

std::unique_ptr<device::HandMotion> MakeHand(const CommandLine& line, mwidth::model::AxisKind kind) {
  if (line.hand_motion.empty()) {
    return std::make_unique<device::MinimumJerkReach>(device::DefaultReach(kind));
  }
  return std::make_unique<device::RecordedMotion>(line.hand_motion, kind, line.reach);
}

// Time passes for the drive although nobody asks, and its watchdog looks whether somebody does.
class Clock {
 public:
  Clock(asio::io_context& context, emulator::Joint& joint, emulator::Link& link)
      : timer_(context), joint_(joint), link_(link) {
    Turn();
  }

 private:
  void Turn() {
    const int64_t now_ns = std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
    link_.Turn(now_ns);
    joint_.Turn(now_ns);
    if (const emulator::Trips trips = joint_.trips(); trips.count > told_) {
      std::cout << "watchdog: the motor is disabled " << std::lround(trips.after_s * 1e3)
                << " ms after the last sign of life" << std::endl;
      told_ = trips.count;
    }
    timer_.expires_after(std::chrono::milliseconds(1));
    timer_.async_wait([this](auto error) {
      if (!error) {
        Turn();
      }
    });
  }

  asio::steady_timer timer_;
  emulator::Joint& joint_;
  emulator::Link& link_;
  int told_ = 0;
};

// A drive has a processor of its own, which this one can only ask for: below the priority of the server's
// loops.
void AskForPriority() {
  constexpr sched_param kPriority{.sched_priority = 40};
  if (sched_setscheduler(0, SCHED_FIFO, &kPriority) != 0) {
    std::cerr << "answers may come late: no real-time priority (run as root, or raise the limit rtprio)\n";
  }
}

std::unique_ptr<emulator::Link> OpenLink(asio::io_context& context, const CommandLine& line,
                                         const server::AxisConfig& axis, emulator::Joint& joint,
                                         const emulator::LinkFaults& faults) {
  if (const auto* modbus = std::get_if<device::modbus::ModbusDriveConfig>(&axis.drive.behind)) {
    return emulator::OpenLink(context, *modbus, line.place, joint, faults);
  }
  const auto& canopen = std::get<device::canopen::CanopenDriveConfig>(axis.drive.behind);
  return emulator::OpenLink(context, canopen, line.place, line.watchdog_s > 0, joint, faults);
}

emulator::JointConfig JointOf(const CommandLine& line, const server::AxisConfig& axis) {
  // A CANopen drive has the time-out that its master gives it.
  const bool own_time_out = std::holds_alternative<device::modbus::ModbusDriveConfig>(axis.drive.behind);
  return {.plant = axis.loop,
          .position_quantum = axis.drive.position_quantum,
          .force_quantum = axis.drive.force_quantum,
          .watchdog_s = own_time_out ? line.watchdog_s : 0};
}

void Serve(const CommandLine& line) {
  const server::AxisConfig axis = FindAxis(line);
  if (axis.drive.simulated()) {
    throw server::ConfigError("axis " + axis.name +
                              " has a simulated drive already; give a configuration with a real one");
  }
  emulator::Joint joint(JointOf(line, axis), MakeHand(line, axis.kind));
  emulator::LinkFaults faults;
  asio::io_context context(1);
  const auto link = OpenLink(context, line, axis, joint, faults);
  AskForPriority();
  asio::signal_set ending(context, SIGINT, SIGTERM);
  ending.async_wait([&context](auto, int) { context.stop(); });
  const Clock clock(context, joint, *link);
  emulator::Commands commands(context, faults, joint, *link);
  std::cout << "listening on " << link->Where() << std::endl;
  context.run();
}

// The whole program, but for failures.
int Run(int argc, char** argv) {
  CLI::App app{
      "mwidth-drive " MWIDTH_VERSION
      ": a drive on a simulated joint, behind the link of a configuration, with its faults on demand"};
  try {
    Serve(Parse(app, argc, argv));
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kExitUsage;
  } catch (const std::invalid_argument& error) {
    std::cerr << "mwidth-drive: " << error.what() << '\n';
    return kExitUsage;
  } catch (const server::ConfigError& error) {
    std::cerr << "mwidth-drive: " << error.what() << '\n';
    return kExitUsage;
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return Run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "mwidth-drive: %s\n", error.what());
    return kExitFailure;
  }
}
