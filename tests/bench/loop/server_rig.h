// A whole server in this process, but for the drive.
#pragma once

#include <cstdint>
#include <string>

#include "server/exchange/crossing.h"
#include "server/gate/axis_gate.h"
#include "server/record/broadcast.h"
#include "server/record/drain.h"
#include "server/record/event_log.h"
#include "server/render/loop.h"
#include "server/rpc/axis_registry.h"
#include "server/rpc/server.h"
#include "tests/bench/loop/replay_drive.h"
#include "tests/bench/loop/watched_clock.h"

namespace mwidth::bench {

/// Loop, gate, record and gRPC server of one axis, wired as mwidthd wires them, around a drive that costs
/// nothing.
class ServerRig {
 public:
  /// Begins to tick and to serve. `clock` outlives the rig.
  ServerRig(WatchedClock& clock, double period_s, const render::RealtimeConfig& realtime);
  ServerRig(const ServerRig&) = delete;
  ServerRig& operator=(const ServerRig&) = delete;
  ~ServerRig();

  const render::RealtimeReport& realtime() const { return realtime_; }
  const std::string& address() const { return server_.address(); }
  exchange::LoopStatus Status() { return gate_.Status(); }
  uint64_t dropped_samples() const { return gate_.dropped_samples(); }
  /// Takes control and renders a mass, as a client would.
  void Render();

 private:
  ReplayDrive drive_;
  exchange::Crossing crossing_;
  record::Broadcast broadcast_;
  record::EventLog events_;
  record::Drain drain_;
  render::Loop loop_;
  render::RealtimeReport realtime_;
  gate::AxisGate gate_;
  rpc::AxisRegistry registry_;
  rpc::Server server_;
};

}  // namespace mwidth::bench
