#include "tests/server/rpc/served_axis.h"

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>

#include "google/rpc/status.pb.h"

namespace mwidth::rpc {
namespace {

gate::AxisDescription Named(const std::string& name) {
  gate::AxisDescription axis = gate::PaperAxis();
  axis.name = name;
  return axis;
}

}  // namespace

TickingAxis::TickingAxis(const std::string& name)
    : name_(name),
      gate_(Named(name), *crossing_, clock_,
            [this](const std::function<bool()>& done) { return Wait(done); }),
      loop_(*crossing_, clock_),
      thread_([this] { Run(); }) {}

TickingAxis::~TickingAxis() {
  over_ = true;
  thread_.join();
}

void TickingAxis::Trip(exchange::Fault fault) {
  const std::lock_guard lock(loop_mutex_);
  loop_.Trip(fault);
}

// As long as the loop ticks it will answer, however busy the host.
bool TickingAxis::Wait(const std::function<bool()>& done) const {
  while (!done()) {
    if (silent_) {
      return done();
    }
    std::this_thread::yield();
  }
  return true;
}

void TickingAxis::Run() {
  while (!over_) {
    if (!silent_) {
      const std::lock_guard lock(loop_mutex_);
      loop_.Tick();
    }
    std::this_thread::yield();
  }
}

Details DetailsOf(const grpc::Status& status) {
  Details details;
  google::rpc::Status parsed;
  EXPECT_TRUE(parsed.ParseFromString(status.error_details()));
  for (const google::protobuf::Any& any : parsed.details()) {
    v1::StabilityReport report;
    if (any.UnpackTo(&report)) {
      details.report = report;
    } else {
      EXPECT_TRUE(any.UnpackTo(&details.info)) << any.type_url();
    }
  }
  return details;
}

void ExpectStatus(const grpc::Status& status, grpc::StatusCode code, const std::string& reason) {
  EXPECT_EQ(status.error_code(), code) << status.error_message();
  EXPECT_FALSE(status.error_message().empty());
  const Details details = DetailsOf(status);
  EXPECT_EQ(details.info.domain(), "mwidth");
  EXPECT_EQ(details.info.reason(), reason);
}

ServedAxis::ServedAxis() {
  axes.Add(axis.Registered());
  server = std::make_unique<Server>(axes, "127.0.0.1:0", "0.0.0-test");
  channel = grpc::CreateChannel(server->address(), grpc::InsecureChannelCredentials());
  rendering = v1::RenderingService::NewStub(channel);
  stability = v1::StabilityService::NewStub(channel);
}

std::string ServedAxis::Acquire(const std::string& client_name) {
  v1::AcquireControlRequest request;
  request.set_client_name(client_name);
  v1::AcquireControlResponse response;
  const grpc::Status status = Call(&Rendering::AcquireControl, *rendering, request, response);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return response.lease().lease_id();
}

std::string ServedAxis::Render(double mass) {
  const std::string lease = Acquire();
  EXPECT_TRUE(SetMass(lease, mass).ok());
  EXPECT_TRUE(Start(lease).ok());
  EXPECT_EQ(State().mass(), mass);
  return lease;
}

grpc::Status ServedAxis::SetMass(const std::string& lease_id, double mass) {
  v1::SetMassRequest request;
  request.set_lease_id(lease_id);
  request.set_mass(mass);
  v1::SetMassResponse response;
  return Call(&Rendering::SetMass, *rendering, request, response);
}

grpc::Status ServedAxis::Start(const std::string& lease_id) {
  v1::StartRenderingRequest request;
  request.set_lease_id(lease_id);
  v1::StartRenderingResponse response;
  return Call(&Rendering::StartRendering, *rendering, request, response);
}

v1::AxisState ServedAxis::State() {
  v1::GetStateResponse response;
  const grpc::Status status = Call(&Rendering::GetState, *rendering, v1::GetStateRequest(), response);
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(response.axes_size(), 1);
  return response.axes_size() == 1 ? response.axes(0) : v1::AxisState();
}

}  // namespace mwidth::rpc
