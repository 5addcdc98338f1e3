#include "tests/client/fake_server.h"

#include <google/protobuf/util/time_util.h>
#include <grpcpp/server_builder.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "tests/client/fake_answers.h"

namespace mwidth::testing {
namespace {

constexpr char kLease[] = "secret";
constexpr auto kPatience = std::chrono::minutes(1);

grpc::Status CheckAxis(const std::string& axis) {
  return axis.empty() || axis == "elbow"
             ? grpc::Status::OK
             : Failure(grpc::StatusCode::NOT_FOUND, "UNKNOWN_AXIS", "no axis " + axis);
}

grpc::Status CheckLease(const std::string& lease_id) {
  return lease_id == kLease
             ? grpc::Status::OK
             : Failure(grpc::StatusCode::FAILED_PRECONDITION, "NO_LEASE", "acquire control first");
}

}  // namespace

class FakeServer::Rendering : public v1::RenderingService::Service {
 public:
  explicit Rendering(FakeServer& fake) : fake_(fake) {}

  grpc::Status GetState(grpc::ServerContext*, const v1::GetStateRequest* request,
                        v1::GetStateResponse* response) override {
    const std::lock_guard lock(fake_.mutex_);
    fake_.axis_.mutable_info()->set_kind(fake_.behaviour_.kind);
    *response->add_axes() = fake_.axis_;
    response->set_server_version("9.9.9");
    return CheckAxis(request->axis());
  }
  grpc::Status AcquireControl(grpc::ServerContext*, const v1::AcquireControlRequest* request,
                              v1::AcquireControlResponse* response) override {
    const std::lock_guard lock(fake_.mutex_);
    if (fake_.behaviour_.held_by_another) {
      return Failure(grpc::StatusCode::FAILED_PRECONDITION, "CONTROL_HELD", "control is held by somebody");
    }
    auto& lease = *response->mutable_lease();
    lease.set_lease_id(kLease);
    *lease.mutable_ttl() = request->has_ttl() ? request->ttl()
                                              : google::protobuf::util::TimeUtil::MillisecondsToDuration(
                                                    static_cast<int64_t>(1e3 * fake_.behaviour_.ttl_s));
    fake_.axis_.set_controller(request->client_name());
    return Called("AcquireControl");
  }
  grpc::Status RenewControl(grpc::ServerContext*, const v1::RenewControlRequest* request,
                            v1::RenewControlResponse*) override {
    const std::lock_guard lock(fake_.mutex_);
    ++fake_.renewals_;
    fake_.changed_.notify_all();
    return fake_.behaviour_.renewal.value_or(CheckLease(request->lease_id()));
  }
  grpc::Status ReleaseControl(grpc::ServerContext*, const v1::ReleaseControlRequest* request,
                              v1::ReleaseControlResponse*) override {
    const std::lock_guard lock(fake_.mutex_);
    const auto status = CheckLease(request->lease_id());
    return status.ok() ? Called("ReleaseControl") : status;
  }
  grpc::Status StartRendering(grpc::ServerContext*, const v1::StartRenderingRequest* request,
                              v1::StartRenderingResponse* response) override {
    const std::lock_guard lock(fake_.mutex_);
    const auto status = CheckLease(request->lease_id());
    if (status.ok()) {
      fake_.axis_.set_state(v1::STATE_RENDERING);
      response->set_state(v1::STATE_RENDERING);
      return Called("StartRendering");
    }
    return status;
  }
  grpc::Status StopRendering(grpc::ServerContext*, const v1::StopRenderingRequest* request,
                             v1::StopRenderingResponse* response) override {
    const std::lock_guard lock(fake_.mutex_);
    const auto status = CheckLease(request->lease_id());
    fake_.axis_.set_state(v1::STATE_READY);
    response->set_state(v1::STATE_READY);
    return status.ok() ? Called("StopRendering") : status;
  }
  grpc::Status SetMass(grpc::ServerContext*, const v1::SetMassRequest* request,
                       v1::SetMassResponse* response) override {
    const std::lock_guard lock(fake_.mutex_);
    if (const auto status = CheckLease(request->lease_id()); !status.ok()) {
      return status;
    }
    if (!std::isfinite(request->mass())) {
      return Failure(grpc::StatusCode::INVALID_ARGUMENT, "INVALID_NUMBER", "mass must be finite");
    }
    const auto report = Report(request->mass());
    if (report.nearest_admitted_mass() != request->mass()) {
      return Failure(grpc::StatusCode::FAILED_PRECONDITION, "UNSTABLE_MASS", "that mass is unstable",
                     &report);
    }
    response->set_mass(request->mass());
    *response->mutable_stability() = report;
    fake_.last_mass_ = *request;
    if (request->validate_only()) {
      return Called("ValidateMass");
    }
    fake_.axis_.set_mass(request->mass());
    fake_.axis_.set_target_mass(request->mass());
    if (fake_.behaviour_.fault_on_mass) {
      LatchFault("the drive did not answer");
    }
    return Called("SetMass");
  }
  // The mass that is set is stable up to a cut-off of 40 Hz.
  grpc::Status SetFilter(grpc::ServerContext*, const v1::SetFilterRequest* request,
                         v1::SetFilterResponse* response) override {
    const std::lock_guard lock(fake_.mutex_);
    if (const auto status = CheckLease(request->lease_id()); !status.ok()) {
      return status;
    }
    if (!(request->cutoff_hz() > 0)) {
      return Failure(grpc::StatusCode::INVALID_ARGUMENT, "INVALID_NUMBER", "cutoff_hz must be above 0");
    }
    auto report = Report(fake_.axis_.target_mass());
    report.mutable_loop()->set_cutoff_hz(request->cutoff_hz());
    if (request->estimator() != v1::ESTIMATOR_KIND_UNSPECIFIED) {
      report.mutable_loop()->set_estimator(request->estimator());
    }
    if (request->cutoff_hz() > kMaxCutoffHz) {
      return Failure(grpc::StatusCode::FAILED_PRECONDITION, "UNSTABLE_MASS",
                     "the mass that is set would be unstable", &report);
    }
    *response->mutable_loop() = report.loop();
    *response->mutable_stability() = report;
    fake_.last_filter_ = *request;
    if (request->validate_only()) {
      return Called("ValidateFilter");
    }
    *fake_.axis_.mutable_info()->mutable_loop() = report.loop();
    response->set_tick(fake_.axis_.tick());
    return Called("SetFilter");
  }
  grpc::Status EmergencyStop(grpc::ServerContext*, const v1::EmergencyStopRequest* request,
                             v1::EmergencyStopResponse* response) override {
    const std::lock_guard lock(fake_.mutex_);
    fake_.stop_reason_ = request->reason();
    LatchFault("emergency stop");
    response->add_states(v1::STATE_FAULT);
    response->add_axes(fake_.axis_.info().name());
    return Called("EmergencyStop");
  }
  grpc::Status ClearFault(grpc::ServerContext*, const v1::ClearFaultRequest* request,
                          v1::ClearFaultResponse* response) override {
    const std::lock_guard lock(fake_.mutex_);
    fake_.axis_.clear_fault();
    fake_.axis_.set_state(v1::STATE_IDLE);
    response->set_state(v1::STATE_IDLE);
    const auto status = CheckLease(request->lease_id());
    return status.ok() ? Called("ClearFault") : status;
  }

 private:
  grpc::Status Called(const std::string& method) {
    fake_.calls_.push_back(method);
    fake_.changed_.notify_all();
    return grpc::Status::OK;
  }
  void LatchFault(const std::string& message) {
    fake_.axis_.set_state(v1::STATE_FAULT);
    fake_.axis_.mutable_fault()->set_kind(v1::FAULT_KIND_EMERGENCY_STOP);
    fake_.axis_.mutable_fault()->set_tick(77);
    fake_.axis_.mutable_fault()->set_message(message);
  }

  FakeServer& fake_;
};

class FakeServer::Stability : public v1::StabilityService::Service {
 public:
  explicit Stability(FakeServer& fake) : fake_(fake) {}

  grpc::Status GetMWidth(grpc::ServerContext*, const v1::GetMWidthRequest* request,
                         v1::GetMWidthResponse* response) override {
    const std::lock_guard lock(fake_.mutex_);
    fake_.last_m_width_ = *request;
    *response->mutable_loop() = Loop();
    response->mutable_loop()->MergeFrom(request->loop());
    *response->mutable_m_width() = Width();
    if (response->loop().device_damping() == 0) {
      auto& empty = *response->mutable_m_width()->mutable_nominal();
      empty.Clear();
      empty.set_empty(true);
      empty.set_empty_reason("without damping no mass is stable");
    }
    return CheckAxis(request->axis());
  }

 private:
  FakeServer& fake_;
};

class FakeServer::Telemetry : public v1::TelemetryService::Service {
 public:
  explicit Telemetry(FakeServer& fake) : fake_(fake) {}

  // Batches without end, from tick 1000; before the third one, two ticks are missed and three not delivered.
  grpc::Status StreamSamples(grpc::ServerContext*, const v1::StreamSamplesRequest* request,
                             grpc::ServerWriter<v1::StreamSamplesResponse>* writer) override {
    if (const auto status = CheckAxis(request->axis()); !status.ok()) {
      return status;
    }
    const uint64_t decimation = std::max(1u, request->decimation());
    uint64_t tick = 1000;
    for (int count = 1;; ++count) {
      v1::StreamSamplesResponse response;
      auto& batch = *response.mutable_batch();
      batch.set_axis("elbow");
      batch.set_decimation(static_cast<uint32_t>(decimation));
      if (count == 3) {
        batch.set_missed_ticks_before(2);
        batch.set_dropped_ticks_before(3);
        tick += 5;
      }
      batch.set_first_tick(tick);
      const auto size = request->max_batch() == 0 ? 100 : request->max_batch();
      for (uint32_t i = 0; i < size; ++i, tick += decimation) {
        AddSample(tick, batch);
        if (request->reduction() == v1::REDUCTION_MIN_MAX) {
          AddExtremes(tick, batch);
        }
      }
      if (!writer->Write(response)) {
        return grpc::Status::CANCELLED;
      }
      const std::lock_guard lock(fake_.mutex_);
      if (count == fake_.behaviour_.end_stream_after_batches) {
        return {grpc::StatusCode::UNAVAILABLE, "the server shuts down"};
      }
    }
  }

 private:
  static void AddSample(uint64_t tick, v1::SampleBatch& batch) {
    batch.add_monotonic_ns(static_cast<int64_t>(tick) * 1'000'000);
    batch.add_position(static_cast<double>(tick) / 3);
    batch.add_velocity(-1);
    batch.add_acceleration(2);
    batch.add_force(0.1);
    batch.add_mass(0.05);
    batch.add_state(v1::STATE_RENDERING);
    batch.add_saturated(tick % 2 == 1);
    batch.add_position_counts(-static_cast<int64_t>(tick));
    batch.add_force_counts(12);
    batch.add_acceleration_counts(-7);
  }

  static void AddExtremes(uint64_t tick, v1::SampleBatch& batch) {
    batch.add_position_min(static_cast<double>(tick));
    batch.add_position_max(static_cast<double>(tick + 1));
    batch.add_velocity_min(-2);
    batch.add_velocity_max(-1);
    batch.add_acceleration_min(1);
    batch.add_acceleration_max(2);
    batch.add_force_min(0);
    batch.add_force_max(0.5);
  }

  FakeServer& fake_;
};

FakeServer::FakeServer()
    : rendering_(std::make_unique<Rendering>(*this)),
      stability_(std::make_unique<Stability>(*this)),
      telemetry_(std::make_unique<Telemetry>(*this)) {
  axis_.mutable_info()->set_name("elbow");
  *axis_.mutable_info()->mutable_loop() = Loop();
  axis_.mutable_info()->set_force_limit(5);
  axis_.mutable_info()->set_simulated(true);
  axis_.set_state(v1::STATE_IDLE);
  axis_.set_tick(123456789012);
  *axis_.mutable_m_width() = Width();
  int port = 0;
  grpc::ServerBuilder builder;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  builder.RegisterService(rendering_.get());
  builder.RegisterService(stability_.get());
  builder.RegisterService(telemetry_.get());
  server_ = builder.BuildAndStart();
  address_ = "127.0.0.1:" + std::to_string(port);
}

FakeServer::~FakeServer() { server_->Shutdown(std::chrono::system_clock::now()); }

void FakeServer::Behave(const Behaviour& behaviour) {
  const std::lock_guard lock(mutex_);
  behaviour_ = behaviour;
}

std::vector<std::string> FakeServer::Calls() const {
  const std::lock_guard lock(mutex_);
  return calls_;
}

int FakeServer::Renewals() const {
  const std::lock_guard lock(mutex_);
  return renewals_;
}

bool FakeServer::WaitForRenewals(int count) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, kPatience, [&] { return renewals_ >= count; });
}

bool FakeServer::WaitForCall(const std::string& method) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, kPatience,
                           [&] { return std::find(calls_.begin(), calls_.end(), method) != calls_.end(); });
}

v1::SetMassRequest FakeServer::LastMass() const {
  const std::lock_guard lock(mutex_);
  return last_mass_;
}

std::string FakeServer::StopReason() const {
  const std::lock_guard lock(mutex_);
  return stop_reason_;
}

v1::SetFilterRequest FakeServer::LastFilter() const {
  const std::lock_guard lock(mutex_);
  return last_filter_;
}

v1::GetMWidthRequest FakeServer::LastMWidth() const {
  const std::lock_guard lock(mutex_);
  return last_m_width_;
}

}  // namespace mwidth::testing
