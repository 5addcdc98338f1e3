#include "client/cpp/control.h"

#include <google/protobuf/util/time_util.h>

#include <utility>

#include "client/cpp/call.h"

namespace mwidth::client {
namespace {

using std::chrono::nanoseconds;
using std::chrono::steady_clock;
using Stub = v1::RenderingService::StubInterface;

nanoseconds TimeToLive(const v1::ControlLease& lease) {
  return nanoseconds(google::protobuf::util::TimeUtil::DurationToNanoseconds(lease.ttl()));
}

// A renewal that failed this way may succeed when tried again.
bool MayRetry(const grpc::Status& status) {
  return status.error_code() == grpc::StatusCode::UNAVAILABLE ||
         status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED;
}

template <typename Request>
Request Addressed(const std::string& axis, const v1::ControlLease& lease) {
  Request request;
  request.set_axis(axis);
  request.set_lease_id(lease.lease_id());
  return request;
}

}  // namespace

Control::Control(std::shared_ptr<Stub> stub, std::string axis, v1::ControlLease lease,
                 steady_clock::time_point sent, Seconds call_timeout)
    : stub_(std::move(stub)),
      axis_(std::move(axis)),
      lease_(std::move(lease)),
      ttl_(TimeToLive(lease_)),
      call_timeout_(call_timeout),
      valid_until_(sent + ttl_),
      renewal_([this](const std::stop_token& stop) { RenewUntilStopped(stop); }) {}

Control::~Control() {
  renewal_.request_stop();
  renewal_.join();
  if (!loss_) {
    Release();
  }
}

v1::StartRenderingResponse Control::StartRendering() {
  return Call(*stub_, &Stub::StartRendering, Addressed<v1::StartRenderingRequest>(axis_, lease_),
              call_timeout_);
}

v1::StopRenderingResponse Control::StopRendering() {
  return Call(*stub_, &Stub::StopRendering, Addressed<v1::StopRenderingRequest>(axis_, lease_),
              call_timeout_);
}

v1::ClearFaultResponse Control::ClearFault() {
  return Call(*stub_, &Stub::ClearFault, Addressed<v1::ClearFaultRequest>(axis_, lease_), call_timeout_);
}

MassAnswer Control::SetMass(double mass, std::optional<Seconds> ramp) {
  auto request = Addressed<v1::SetMassRequest>(axis_, lease_);
  request.set_mass(mass);
  if (ramp) {
    *request.mutable_ramp() = google::protobuf::util::TimeUtil::NanosecondsToDuration(
        std::chrono::duration_cast<nanoseconds>(*ramp).count());
  }
  return CallOrRefusal(*stub_, &Stub::SetMass, request, call_timeout_);
}

MassAnswer Control::ValidateMass(double mass) {
  auto request = Addressed<v1::SetMassRequest>(axis_, lease_);
  request.set_mass(mass);
  request.set_validate_only(true);
  return CallOrRefusal(*stub_, &Stub::SetMass, request, call_timeout_);
}

FilterAnswer Control::SetFilter(v1::EstimatorKind estimator, double cutoff_hz) {
  return RequestFilter(estimator, cutoff_hz, /*validate_only=*/false);
}

FilterAnswer Control::ValidateFilter(v1::EstimatorKind estimator, double cutoff_hz) {
  return RequestFilter(estimator, cutoff_hz, /*validate_only=*/true);
}

FilterAnswer Control::RequestFilter(v1::EstimatorKind estimator, double cutoff_hz, bool validate_only) {
  auto request = Addressed<v1::SetFilterRequest>(axis_, lease_);
  request.set_estimator(estimator);
  request.set_cutoff_hz(cutoff_hz);
  request.set_validate_only(validate_only);
  return CallOrRefusal(*stub_, &Stub::SetFilter, request, call_timeout_);
}

std::optional<Error> Control::Loss() const {
  const std::lock_guard lock(mutex_);
  return loss_;
}

bool Control::WaitForLoss(std::stop_token stop, Seconds timeout) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, std::move(stop), timeout, [this] { return loss_.has_value(); });
}

void Control::RenewUntilStopped(const std::stop_token& stop) {
  const auto request = Addressed<v1::RenewControlRequest>(axis_, lease_);
  // A third of the time to live leaves room for one slow renewal and a second try before the lease expires.
  auto pause = ttl_ / 3;
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait_for(lock, stop, pause, [] { return false; });
    if (stop.stop_requested()) {
      return;
    }
    lock.unlock();
    const auto sent = steady_clock::now();
    grpc::ClientContext context;
    SetTimeout(context, ttl_ / 6);
    const std::stop_callback cancel(stop, [&context] { context.TryCancel(); });
    v1::RenewControlResponse response;
    const auto status = stub_->RenewControl(&context, request, &response);
    lock.lock();
    if (stop.stop_requested()) {
      return;
    }
    if (status.ok()) {
      // Counted from before the request left: the server counts from later, never from earlier.
      valid_until_ = sent + ttl_;
      pause = ttl_ / 3;
    } else if (MayRetry(status) && steady_clock::now() < valid_until_) {
      pause = ttl_ / 12;
    } else {
      loss_.emplace(CallError(status));
      changed_.notify_all();
      return;
    }
  }
}

void Control::Release() noexcept {
  try {
    Call(*stub_, &Stub::ReleaseControl, Addressed<v1::ReleaseControlRequest>(axis_, lease_),
         std::chrono::seconds(1));
  } catch (const std::exception&) {  // NOLINT(bugprone-empty-catch): unreleased, the lease expires by itself
  }
}

}  // namespace mwidth::client
