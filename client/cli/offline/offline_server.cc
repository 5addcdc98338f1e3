#include "client/cli/offline/offline_server.h"

#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include <deque>
#include <stdexcept>

#include "server/config.h"
#include "server/describe_axis.h"
#include "server/exchange/clock.h"
#include "server/exchange/crossing.h"
#include "server/gate/axis_gate.h"
#include "server/record/broadcast.h"
#include "server/record/event_log.h"
#include "server/rpc/axis_registry.h"
#include "server/rpc/rendering_service.h"
#include "server/rpc/sample_encoding.h"
#include "server/rpc/stability_service.h"

namespace mwidth::offline {
namespace {

// An axis whose loop never ticks.
struct Axis {
  explicit Axis(const server::AxisConfig& config)
      : broadcast(rpc::SampleEncoding(config.name)), gate(server::DescribeAxis(config), crossing, clock) {}

  exchange::MonotonicClock clock;
  exchange::Crossing crossing;
  record::Broadcast broadcast;
  record::EventLog events{clock};
  gate::AxisGate gate;
};

}  // namespace

struct OfflineServer::Parts {
  explicit Parts(const server::Config& config) {
    for (const auto& axis : config.axes) {
      auto& added = axes.emplace_back(axis);
      registry.Add({.name = axis.name,
                    .gate = added.gate,
                    .broadcast = added.broadcast,
                    .events = added.events,
                    .clock = added.clock});
    }
    grpc::ServerBuilder builder;
    builder.RegisterService(&rendering);
    builder.RegisterService(&stability);
    server = builder.BuildAndStart();
    if (!server) {
      throw std::runtime_error("cannot start the services in this process");
    }
  }

  // Gates do not move.
  std::deque<Axis> axes;
  rpc::AxisRegistry registry;
  rpc::RenderingService rendering{registry, MWIDTH_VERSION};
  rpc::StabilityService stability{registry};
  std::unique_ptr<grpc::Server> server;
};

OfflineServer::OfflineServer(const std::string& name_or_file)
    : parts_(std::make_unique<Parts>(server::LoadConfig(server::FindConfig(name_or_file)))) {}

OfflineServer::~OfflineServer() { parts_->server->Shutdown(); }

std::shared_ptr<grpc::Channel> OfflineServer::Connect() { return parts_->server->InProcessChannel({}); }

}  // namespace mwidth::offline
