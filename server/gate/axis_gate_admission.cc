// What passes the stability gate before it is posted: masses and filters.
#include <memory>
#include <optional>
#include <utility>

#include "server/gate/axis_gate.h"
#include "server/gate/invalid_number.h"
#include "server/gate/state_refusals.h"

namespace mwidth::gate {

using exchange::LoopStatus;
using exchange::State;

std::optional<Refusal> AxisGate::CheckMaySet() {
  const LoopStatus& status = loop_.NewestStatus();
  if (status.state == State::kFault) {
    return InFault(status);
  }
  if (loop_.StopPending()) {
    return StillStopping(status);
  }
  return std::nullopt;
}

std::optional<Result<Posted>> AxisGate::PostMass(const std::string& lease_id, const MassRequest& request,
                                                 const std::shared_ptr<const StabilityGate>& judged) {
  const std::lock_guard lock(mutex_);
  // Once more: the lease may have expired while stability was computed.
  if (std::optional<Refusal> refusal = lease_.Check(lease_id, clock_.NowNs())) {
    return *std::move(refusal);
  }
  if (judged != stability_) {
    return std::nullopt;
  }
  if (std::optional<Refusal> refusal = CheckMaySet()) {
    return *std::move(refusal);
  }
  return request.validate_only ? Posted{} : loop_.SetMass(request.mass, request.ramp_s);
}

Result<MassGrant> AxisGate::SetMass(const std::string& lease_id, const MassRequest& request) {
  if (std::optional<Refusal> refusal = CheckLease(lease_id)) {
    return *std::move(refusal);
  }
  if (std::optional<Refusal> refusal = CheckNumbers(request, description_)) {
    return *std::move(refusal);
  }
  MassGrant grant{.mass = request.mass, .stability = {}, .accuracy = {}, .tick = 0};
  std::optional<Result<Posted>> posted;
  while (!posted) {
    const std::shared_ptr<const StabilityGate> judge = stability();
    grant.stability = judge->Judge(request.mass, {.min = description_.mass_min, .max = description_.mass_max},
                                   description_.kind);
    if (!grant.stability.admitted) {
      return InadmissibleMass(grant.stability, description_);
    }
    posted = PostMass(lease_id, request, judge);
  }
  if (!posted->ok()) {
    return posted->refusal();
  }
  grant.accuracy = PredictAccuracy(grant.stability.loop, request.mass, kDefaultBand,
                                   description_.position_quantum, description_.acceleration_quantum);
  if (!request.validate_only) {
    const Result<LoopStatus> answer = Await(**posted, [](const LoopStatus&) { return true; });
    if (!answer.ok()) {
      return answer.refusal();
    }
    if (answer->state == State::kFault) {
      return InFault(*answer);
    }
    grant.tick = answer->tick;
  }
  return grant;
}

std::optional<Result<Posted>> AxisGate::PostFilter(const std::string& lease_id, const FilterRequest& request,
                                                   const std::shared_ptr<const StabilityGate>& judged,
                                                   double judged_mass) {
  const std::lock_guard lock(mutex_);
  if (std::optional<Refusal> refusal = lease_.Check(lease_id, clock_.NowNs())) {
    return *std::move(refusal);
  }
  if (loop_.KeptMass() != judged_mass) {
    return std::nullopt;
  }
  if (std::optional<Refusal> refusal = CheckMaySet()) {
    return *std::move(refusal);
  }
  if (request.validate_only) {
    return Posted{};
  }
  stability_ = judged;
  return loop_.SetFilter(FilterOf(judged->loop()), judged->lower_critical_hz());
}

Result<FilterGrant> AxisGate::SetFilter(const std::string& lease_id, const FilterRequest& request) {
  if (std::optional<Refusal> refusal = CheckLease(lease_id)) {
    return *std::move(refusal);
  }
  FilterGrant grant{.loop = description_.loop, .stability = {}, .tick = 0};
  grant.loop.estimator = request.estimator;
  grant.loop.cutoff_hz = request.cutoff_hz;
  if (model::IsAccelerometer(request.estimator) && description_.acceleration_quantum == 0) {
    return InvalidNumber({.parameter = "estimator",
                          .value = static_cast<double>(request.estimator),
                          .allowed = "one that estimates from positions: this axis has no accelerometer"});
  }
  if (const auto error = model::Validate(grant.loop)) {
    return InvalidNumber(*error);
  }
  // An accelerometer adds to the delay that is assumed.
  const Requirements requirements = description_.Requirements();
  if (const auto error = model::Validate(AssumedLoops(grant.loop, requirements))) {
    return InvalidNumber(*error);
  }
  const auto filtered = std::make_shared<const StabilityGate>(grant.loop, requirements, certificates_);
  std::optional<Result<Posted>> posted;
  while (!posted) {
    grant.stability = filtered->Judge(
        KeptMass(), {.min = description_.mass_min, .max = description_.mass_max}, description_.kind);
    if (!grant.stability.admitted) {
      return InadmissibleWithFilter(grant.stability, description_);
    }
    posted = PostFilter(lease_id, request, filtered, grant.stability.requested_mass);
  }
  if (!posted->ok()) {
    return posted->refusal();
  }
  if (!request.validate_only) {
    const exchange::Filter filter = FilterOf(grant.loop);
    const Result<LoopStatus> answer = Await(**posted, [&filter](const LoopStatus& status) {
      return status.filter == filter || status.state == State::kFault;
    });
    if (!answer.ok()) {
      return answer.refusal();
    }
    if (answer->state == State::kFault) {
      return InFault(*answer);
    }
    grant.tick = answer->tick;
  }
  return grant;
}

}  // namespace mwidth::gate
