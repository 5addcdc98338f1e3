// One axis, whole: its drive, its loop, its gate and its record, wired.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "device/drive.h"
#include "server/config.h"
#include "server/exchange/clock.h"
#include "server/exchange/crossing.h"
#include "server/gate/axis_gate.h"
#include "server/record/broadcast.h"
#include "server/record/drain.h"
#include "server/record/event_log.h"
#include "server/record/loop_events.h"
#include "server/record/session/session_recorder.h"
#include "server/record/session/session_store.h"
#include "server/render/loop.h"
#include "server/rpc/axis_registry.h"

namespace mwidth::server {

/// What the command line decides for every axis.
struct AxisOptions {
  /// Simulated axes run in lock step with their clock, this many times as fast as real time at most; none: in
  /// real time, where deadlines can be missed.
  std::optional<double> simulation_speed;
  bool allow_non_realtime = false;
  /// What was asked of the host for all axes at once and refused, with what to do about it; empty: nothing.
  std::string host_refusal;
};

/// Owns everything of one axis. The loop runs from construction to Stop; it renders only when the gate is
/// asked to.
class Axis {
 public:
  /// Throws ConfigError where the hand's recording cannot be used, and std::invalid_argument for a
  /// contradiction in the configuration.
  /// `store` outlives the axis.
  Axis(const AxisConfig& config, const Config& server, const AxisOptions& options,
       record::SessionStore& store);
  Axis(const Axis&) = delete;
  Axis& operator=(const Axis&) = delete;
  /// Stops.
  ~Axis();

  /// Begins to ramp down what is rendered, and returns at once.
  void BeginStop();
  /// Ramps down what is rendered, then ends the loop, then the session and the streams. Does no harm twice.
  void Stop();

  /// What the services need of it; valid as long as the axis.
  rpc::Axis Served();
  const gate::AxisDescription& description() const { return gate_->description(); }

 private:
  void EndSession();
  record::StateNote DescribeChange(exchange::State from, exchange::State to);

  std::unique_ptr<exchange::Clock> clock_;
  std::unique_ptr<device::Drive> drive_;
  exchange::Crossing crossing_;
  record::Broadcast broadcast_;
  record::EventLog events_;
  record::LoopEvents loop_events_;
  record::SessionRecorder recorder_;
  record::Drain drain_;
  std::unique_ptr<render::Loop> loop_;
  std::unique_ptr<gate::AxisGate> gate_;
};

}  // namespace mwidth::server
