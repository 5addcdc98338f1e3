#include "server/axis.h"

#include <chrono>
#include <iostream>
#include <limits>
#include <stdexcept>
#include <utility>

#include "device/canopen/canopen_drive.h"
#include "device/hand_motion.h"
#include "device/modbus/modbus_drive.h"
#include "device/simulated_drive.h"
#include "server/describe_axis.h"
#include "server/gate/figures.h"
#include "server/gate/state_words.h"
#include "server/rpc/sample_encoding.h"

namespace mwidth::server {
namespace {

// How long a sample waits for its subscribers at most, and how many arrive at once; twice of it where all of
// them want large batches.
constexpr std::chrono::milliseconds kDrainPeriod{5};

constexpr int64_t kNsPerUs = 1000;

std::unique_ptr<exchange::Clock> MakeClock(const AxisConfig& config, const AxisOptions& options) {
  if (options.simulation_speed) {
    if (!config.drive.simulated()) {
      throw ConfigError("--simulation-speed: axis " + config.name +
                        " has a real drive, whose time nobody can turn");
    }
    return std::make_unique<exchange::SimulatedClock>(*options.simulation_speed);
  }
  return std::make_unique<exchange::MonotonicClock>(config.realtime.spin_us * kNsPerUs);
}

std::unique_ptr<device::HandMotion> MakeHandMotion(const HandMotionConfig& motion, model::AxisKind kind) {
  if (!motion.file.empty()) {
    try {
      return std::make_unique<device::RecordedMotion>(motion.file, kind, motion.reach);
    } catch (const std::runtime_error& error) {
      throw ConfigError(error.what());
    }
  }
  return std::make_unique<device::MinimumJerkReach>(device::ReachParameters{
      .amplitude = motion.amplitude, .duration_s = motion.duration_s, .hold_s = motion.hold_s});
}

std::unique_ptr<device::Drive> MakeDrive(const AxisConfig& config) {
  if (const auto* modbus = std::get_if<device::modbus::ModbusDriveConfig>(&config.drive.behind)) {
    return std::make_unique<device::modbus::ModbusDrive>(*modbus);
  }
  if (const auto* canopen = std::get_if<device::canopen::CanopenDriveConfig>(&config.drive.behind)) {
    return std::make_unique<device::canopen::CanopenDrive>(*canopen);
  }
  return std::make_unique<device::SimulatedDrive>(
      device::SimulatedDriveConfig{.loop = config.loop,
                                   .position_quantum = config.drive.position_quantum,
                                   .force_quantum = config.drive.force_quantum,
                                   .acceleration_quantum = config.drive.acceleration_quantum},
      MakeHandMotion(std::get<HandMotionConfig>(config.drive.behind), config.kind));
}

render::LoopConfig MakeLoopConfig(const AxisConfig& config) {
  render::LoopConfig loop;
  loop.period_s = config.loop.period_s;
  loop.estimator = config.loop.estimator;
  loop.cutoff_hz = config.loop.cutoff_hz;
  loop.force_limit = config.limits.force;
  loop.force_slew_limit = config.limits.force_slew.value_or(std::numeric_limits<double>::infinity());
  loop.position_min = config.limits.position_min;
  loop.position_max = config.limits.position_max;
  loop.velocity_limit = config.limits.velocity;
  loop.max_missed_ticks = static_cast<uint32_t>(config.limits.max_missed_ticks);
  loop.watch = config.watch;
  loop.hand_monitor = config.hand_monitor;
  loop.realtime.priority = config.realtime.priority;
  loop.realtime.cpu = config.realtime.cpu.value_or(-1);
  loop.realtime.allow_deep_idle = config.realtime.allow_deep_idle;
  return loop;
}

int64_t WallNs() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

// Where an axis's time is simulated, so is its day: else the wall clock would step against it all the time.
record::SessionClocks SessionClocksOf(const exchange::Clock& clock, bool simulated) {
  const auto monotonic_ns = [&clock] { return clock.NowNs(); };
  if (!simulated) {
    return {.wall_ns = WallNs, .monotonic_ns = monotonic_ns};
  }
  const int64_t offset_ns = WallNs() - clock.NowNs();
  return {.wall_ns = [&clock, offset_ns] { return clock.NowNs() + offset_ns; }, .monotonic_ns = monotonic_ns};
}

gate::AxisDescription Describe(const AxisConfig& config, const device::DriveInfo& drive,
                               const render::RealtimeReport& realtime, const AxisOptions& options) {
  gate::AxisDescription description = DescribeAxis(config);
  description.simulated = drive.simulated;
  // What the loop itself computes with: records are computed again from it, bit for bit.
  description.position_quantum = drive.position_quantum;
  description.force_quantum = drive.force_quantum;
  description.realtime = realtime.realtime;
  description.realtime_message = realtime.message;
  description.rendering_blocked_reason =
      RenderingBlockedReason(drive.simulated, realtime, options.allow_non_realtime);
  return description;
}

}  // namespace

Axis::Axis(const AxisConfig& config, const Config& server, const AxisOptions& options,
           record::SessionStore& store)
    : clock_(MakeClock(config, options)),
      drive_(MakeDrive(config)),
      broadcast_(rpc::SampleEncoding(config.name),
                 {.max_subscribers = static_cast<std::size_t>(server.max_streams),
                  .max_queued_samples = static_cast<std::size_t>(server.stream_queue_samples)}),
      events_(*clock_),
      loop_events_(events_,
                   [this](exchange::State from, exchange::State to) { return DescribeChange(from, to); }),
      recorder_(
          store, {.queue_samples = static_cast<std::size_t>(server.sessions.queue_samples)},
          [this](record::EventKind kind, std::string message, record::EventLog::Metadata metadata) {
            std::cerr << "axis " << gate_->description().name << ": " << message << std::endl;
            events_.Publish(kind, std::move(message), std::move(metadata));
          },
          SessionClocksOf(*clock_, options.simulation_speed.has_value())),
      drain_(crossing_.samples, {&broadcast_, &loop_events_, &recorder_}, kDrainPeriod),
      loop_(std::make_unique<render::Loop>(*drive_, crossing_, *clock_, MakeLoopConfig(config))) {
  render::RealtimeReport realtime = loop_->Start();
  render::AddRefusal(options.host_refusal, realtime);
  gate_ = std::make_unique<gate::AxisGate>(Describe(config, drive_->Info(), realtime, options), crossing_,
                                           *clock_);
  events_.SetSink([this](const record::Event& event) { recorder_.AddEvent(event); });
  // Not before the gate is there, which it asks. What the ring cannot hold until then is of an idle axis.
  drain_.Start();
}

Axis::~Axis() { Stop(); }

rpc::Axis Axis::Served() {
  return {.name = gate_->description().name,
          .gate = *gate_,
          .broadcast = broadcast_,
          .events = events_,
          .clock = *clock_,
          .recorder = &recorder_};
}

record::StateNote Axis::DescribeChange(exchange::State from, exchange::State to) {
  record::StateNote note{.message = "From " + gate::StateName(from) + " to " + gate::StateName(to) + ".",
                         .metadata = {{"from", gate::StateName(from)}, {"to", gate::StateName(to)}}};
  if (gate_ == nullptr) {
    return note;  // it could not be made, and what the loop left is drained
  }
  if (to == exchange::State::kFault) {
    const exchange::FaultRecord fault = gate_->Status().fault;
    if (fault.fault == exchange::Fault::kNone) {
      return note;  // cleared since
    }
    note.message = gate::FaultMessage(fault);
    note.metadata["fault"] = std::to_string(static_cast<int>(fault.fault));
    note.metadata["value"] = gate::Figure(fault.value);
    note.metadata["limit"] = gate::Figure(fault.limit);
  } else if (from == exchange::State::kRendering && gate_->Controller().empty()) {
    note.message += " Nobody has control: its lease was given back, or expired.";
  }
  return note;
}

void Axis::BeginStop() {
  events_.Publish(record::EventKind::kServerStopping, "The server stops.");
  loop_->BeginStop();
}

void Axis::Stop() {
  loop_->Stop();
  drain_.Stop();
  EndSession();
  broadcast_.Close();
  events_.Close();
}

void Axis::EndSession() {
  const auto active = recorder_.Active();
  if (!active) {
    return;
  }
  try {
    events_.Publish(record::EventKind::kSessionEnded, "Session " + active->id + " ends with the server.",
                    {{"session_id", active->id}});
    recorder_.End(active->id);
  } catch (const record::SessionRefused& refused) {
    std::cerr << "axis " << gate_->description().name << ": " << refused.what() << std::endl;
  }
}

}  // namespace mwidth::server
