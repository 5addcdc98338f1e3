#include "tests/bench/loop/server_rig.h"

#include <chrono>
#include <stdexcept>

#include "server/rpc/sample_encoding.h"

namespace mwidth::bench {
namespace {

constexpr std::size_t kMaxStreams = 1024;
constexpr std::size_t kQueuedSamples = 20'000;
constexpr std::chrono::milliseconds kDrainPeriod{5};

// The elbow configuration's joint; limits that its reach does not touch.
gate::AxisDescription Joint(double period_s) {
  gate::AxisDescription joint;
  joint.name = "joint";
  joint.kind = model::AxisKind::kRotary;
  joint.loop = {.device_mass = 0.2084,
                .device_damping = 0.1215,
                .hand_mass = 0.0685,
                .hand_damping = 1,
                .hand_stiffness = 25,
                .period_s = period_s,
                .cutoff_hz = 20};
  joint.mass_min = -100;
  joint.mass_max = 100;
  joint.force_limit = 100;
  joint.required_gain_margin_db = 3;
  joint.position_quantum = ReplayDrive().Info().position_quantum;
  joint.simulated = true;
  return joint;
}

render::LoopConfig LoopOf(const gate::AxisDescription& joint, const render::RealtimeConfig& realtime) {
  render::LoopConfig loop;
  loop.period_s = joint.loop.period_s;
  loop.estimator = joint.loop.estimator;
  loop.cutoff_hz = joint.loop.cutoff_hz;
  loop.force_limit = joint.force_limit;
  loop.position_min = -10;
  loop.position_max = 10;
  loop.velocity_limit = 1000;
  loop.max_missed_ticks = 16;
  loop.watch.delay_limit_s = loop.period_s;
  loop.watch.acceleration_limit = loop.velocity_limit / loop.period_s;
  loop.watch.freeze_velocity = 1;
  loop.realtime = realtime;
  return loop;
}

template <typename T>
T Granted(gate::Result<T> result) {
  if (!result.ok()) {
    throw std::runtime_error(result.refusal().message);
  }
  return *result;
}

}  // namespace

ServerRig::ServerRig(WatchedClock& clock, double period_s, const render::RealtimeConfig& realtime)
    : broadcast_(rpc::SampleEncoding("joint"),
                 {.max_subscribers = kMaxStreams, .max_queued_samples = kQueuedSamples}),
      events_(clock),
      drain_(crossing_.samples, {&broadcast_}, kDrainPeriod),
      loop_(drive_, crossing_, clock, LoopOf(Joint(period_s), realtime)),
      realtime_(loop_.Start()),
      gate_(Joint(period_s), crossing_, clock),
      registry_([this, &clock] {
        rpc::AxisRegistry registry;
        registry.Add(
            {.name = "joint", .gate = gate_, .broadcast = broadcast_, .events = events_, .clock = clock});
        return registry;
      }()),
      server_(registry_, "127.0.0.1:0", "bench") {
  drain_.Start();
}

ServerRig::~ServerRig() {
  loop_.Stop();
  drain_.Stop();
  broadcast_.Close();
  server_.Shutdown(std::chrono::milliseconds(500));
}

void ServerRig::Render() {
  const std::string lease = Granted(gate_.AcquireControl("bench", 60)).id;
  Granted(gate_.SetMass(lease, {.mass = 0.05}));
  Granted(gate_.StartRendering(lease));
}

}  // namespace mwidth::bench
