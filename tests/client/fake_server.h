// A server that answers as mwidthd does, without a loop, a gate or a model: for tests of the clients.
#pragma once

#include <grpcpp/server.h>
#include <mwidth/v1/rendering.grpc.pb.h>
#include <mwidth/v1/stability.grpc.pb.h>
#include <mwidth/v1/telemetry.grpc.pb.h>

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "tests/client/fake_answers.h"

namespace mwidth::testing {

/// Listens on a free port of the loopback until it is destroyed. The axis is "elbow". Every function may be
/// called from any thread.
class FakeServer {
 public:
  FakeServer();
  FakeServer(const FakeServer&) = delete;
  FakeServer& operator=(const FakeServer&) = delete;
  ~FakeServer();

  const std::string& address() const { return address_; }

  /// Behaviour, for a test to change before it acts.
  struct Behaviour {
    v1::AxisKind kind = v1::AXIS_KIND_ROTARY;
    /// Time to live where the client asks for none.
    double ttl_s = 1;
    /// Refuses control with CONTROL_HELD.
    bool held_by_another = false;
    /// Answers renewals so.
    std::optional<grpc::Status> renewal = std::nullopt;
    /// Ends a stream with UNAVAILABLE after so many batches; 0: never.
    int end_stream_after_batches = 0;
    /// Latches a fault when the mass is set.
    bool fault_on_mass = false;
  };
  void Behave(const Behaviour& behaviour);

  /// Methods that were called and answered OK, in order, renewals and states left out.
  std::vector<std::string> Calls() const;
  /// Number of renewals that were answered, well or not.
  int Renewals() const;
  /// Waits until `count` renewals were answered; false where that takes more than a minute.
  bool WaitForRenewals(int count);
  /// Waits until `method` is among the calls; false where that takes more than a minute.
  bool WaitForCall(const std::string& method);
  v1::SetMassRequest LastMass() const;
  std::string StopReason() const;
  v1::SetFilterRequest LastFilter() const;
  v1::GetMWidthRequest LastMWidth() const;

 private:
  class Rendering;
  class Stability;
  class Telemetry;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  Behaviour behaviour_;
  std::vector<std::string> calls_;
  int renewals_ = 0;
  v1::SetMassRequest last_mass_;
  std::string stop_reason_;
  v1::SetFilterRequest last_filter_;
  v1::GetMWidthRequest last_m_width_;
  v1::AxisState axis_;

  std::unique_ptr<Rendering> rendering_;
  std::unique_ptr<Stability> stability_;
  std::unique_ptr<Telemetry> telemetry_;
  std::unique_ptr<grpc::Server> server_;
  std::string address_;
};

}  // namespace mwidth::testing
