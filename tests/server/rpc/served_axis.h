// A server on a loopback port with axes whose loops tick on a thread, and a client that calls it.
#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "google/rpc/error_details.pb.h"
#include "mwidth/v1/rendering.grpc.pb.h"
#include "mwidth/v1/stability.grpc.pb.h"
#include "server/gate/axis_gate.h"
#include "server/record/broadcast.h"
#include "server/record/event_log.h"
#include "server/rpc/axis_registry.h"
#include "server/rpc/sample_encoding.h"
#include "server/rpc/server.h"
#include "tests/server/gate/axis_fixture.h"

namespace mwidth::rpc {

/// One axis of the paper's loop; its fake loop ticks until destroyed, at a time that stands still unless
/// advanced.
class TickingAxis {
 public:
  explicit TickingAxis(const std::string& name);
  ~TickingAxis();

  Axis Registered() {
    return {.name = name_, .gate = gate_, .broadcast = broadcast_, .events = events_, .clock = clock_};
  }
  record::EventLog& events() { return events_; }
  /// The loop answers no more.
  void Silence() { silent_ = true; }
  void AdvanceS(double seconds) { clock_.AdvanceS(seconds); }
  void Trip(exchange::Fault fault);
  exchange::LoopStatus Status() { return gate_.Status(); }

 private:
  bool Wait(const std::function<bool()>& done) const;
  void Run();

  std::string name_;
  gate::FakeClock clock_;
  std::unique_ptr<exchange::Crossing> crossing_ = std::make_unique<exchange::Crossing>();
  gate::AxisGate gate_;
  record::Broadcast broadcast_{SampleEncoding(name_)};
  record::EventLog events_{clock_};
  std::mutex loop_mutex_;
  gate::FakeLoop loop_;
  std::atomic<bool> silent_{false};
  std::atomic<bool> over_{false};
  std::thread thread_;
};

/// What a client reads from the details of a status.
struct Details {
  google::rpc::ErrorInfo info;
  std::optional<v1::StabilityReport> report;
};

/// Empty where there are none.
Details DetailsOf(const grpc::Status& status);

/// Expects this code, and an ErrorInfo of domain mwidth with this reason, and a message.
void ExpectStatus(const grpc::Status& status, grpc::StatusCode code, const std::string& reason);

/// Calls a method of a stub as a client does, with a deadline.
template <typename Stub, typename Request, typename Response>
grpc::Status Call(grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Response*), Stub& stub,
                  const Request& request, Response& response) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(20));
  return (stub.*method)(&context, request, &response);
}

/// One axis, "arm", and everything a client needs to call its server.
class ServedAxis : public testing::Test {
 protected:
  using Rendering = v1::RenderingService::Stub;

  ServedAxis();

  std::string Acquire(const std::string& client_name = "test");
  /// A lease whose axis renders `mass`.
  std::string Render(double mass);
  grpc::Status SetMass(const std::string& lease_id, double mass);
  grpc::Status Start(const std::string& lease_id);
  v1::AxisState State();

  TickingAxis axis{"arm"};
  AxisRegistry axes;
  std::unique_ptr<Server> server;
  std::shared_ptr<grpc::Channel> channel;
  std::unique_ptr<Rendering> rendering;
  std::unique_ptr<v1::StabilityService::Stub> stability;
};

}  // namespace mwidth::rpc
