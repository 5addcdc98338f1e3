#include <chrono>

#include "server/exchange/clock.h"
#include "server/gate/axis_gate.h"
#include "server/record/broadcast.h"
#include "server/record/drain.h"
#include "server/record/event_log.h"
#include "server/rpc/axis_registry.h"
#include "server/rpc/sample_encoding.h"
#include "server/rpc/server.h"
#include "tests/bench/streams/feeder.h"
#include "tests/bench/streams/servers.h"

namespace mwidth::bench {
namespace {

constexpr std::size_t kMaxStreams = 2048;
constexpr std::size_t kQueuedSamples = 20'000;
constexpr std::chrono::milliseconds kDrainPeriod{5};

gate::AxisDescription Joint() {
  gate::AxisDescription joint;
  joint.name = "joint";
  joint.loop = {
      .device_mass = 0.2, .hand_damping = 1, .hand_stiffness = 25, .period_s = 1e-3, .cutoff_hz = 20};
  joint.mass_min = -1;
  joint.mass_max = 1;
  joint.force_limit = 100;
  joint.required_gain_margin_db = 3;
  return joint;
}

class SharedServer final : public StreamServer {
 public:
  SharedServer()
      : registry_([this] {
          rpc::AxisRegistry registry;
          registry.Add(
              {.name = "joint", .gate = gate_, .broadcast = broadcast_, .events = events_, .clock = clock_});
          return registry;
        }()),
        server_(registry_, "127.0.0.1:0", "bench"),
        feeder_([this](const exchange::Sample& sample) {
          exchange::LoopStatus status;
          status.tick = sample.tick;
          crossing_->status.Post(status);
          crossing_->samples.Push(sample);
        }) {
    drain_.Start();
  }
  ~SharedServer() override {
    drain_.Stop();
    broadcast_.Close();
    server_.Shutdown(std::chrono::milliseconds(0));
  }

  std::string address() const override { return server_.address(); }
  double FeederCpuS() const override { return feeder_.CpuS(); }

 private:
  exchange::MonotonicClock clock_;
  const std::unique_ptr<exchange::Crossing> crossing_ = std::make_unique<exchange::Crossing>();
  record::Broadcast broadcast_{rpc::SampleEncoding("joint"),
                               {.max_subscribers = kMaxStreams, .max_queued_samples = kQueuedSamples}};
  record::EventLog events_{clock_};
  record::Drain drain_{crossing_->samples, {&broadcast_}, kDrainPeriod};
  gate::AxisGate gate_{Joint(), *crossing_, clock_};
  rpc::AxisRegistry registry_;
  rpc::Server server_;
  Feeder feeder_;
};

}  // namespace

std::unique_ptr<StreamServer> MakeSharedServer() { return std::make_unique<SharedServer>(); }

}  // namespace mwidth::bench
