#include "server/gate/axis_gate.h"

#include <cmath>
#include <stdexcept>
#include <utility>

#include "server/gate/figures.h"
#include "server/gate/state_refusals.h"
#include "server/gate/state_words.h"

namespace mwidth::gate {
namespace {

using exchange::LoopStatus;
using exchange::State;

AxisDescription Checked(AxisDescription axis) {
  const bool limits_hold_zero = std::isfinite(axis.mass_min) && std::isfinite(axis.mass_max) &&
                                axis.mass_min <= 0 && axis.mass_max >= 0;
  if (!limits_hold_zero) {
    throw std::invalid_argument("the mass limits of axis '" + axis.name + "' are " + Figure(axis.mass_min) +
                                " and " + Figure(axis.mass_max) + ": they must be finite and hold 0 between");
  }
  return axis;
}

bool NotRendering(const LoopStatus& status) { return status.state != State::kRendering; }

}  // namespace

AxisGate::AxisGate(AxisDescription description, exchange::Crossing& crossing, const exchange::Clock& clock,
                   WaitForLoop wait)
    : description_(Checked(std::move(description))),
      crossing_(crossing),
      clock_(clock),
      wait_(std::move(wait)),
      stability_(std::make_shared<const StabilityGate>(description_.loop, description_.Requirements(),
                                                       certificates_)),
      loop_(crossing, FilterOf(description_.loop), stability_->lower_critical_hz()) {}

std::shared_ptr<const StabilityGate> AxisGate::stability() {
  const std::lock_guard lock(mutex_);
  return stability_;
}

Result<Lease> AxisGate::AcquireControl(const std::string& client_name, double ttl_s) {
  std::string id = RandomLeaseId();
  const std::lock_guard lock(mutex_);
  Result<Lease> lease = lease_.Acquire(std::move(id), client_name, ttl_s, clock_.NowNs());
  if (lease.ok()) {
    // A late loop may not have seen the previous lease expire: it must not take the new deadline for a
    // renewal.
    loop_.Stop();
    loop_.SetDeadline(lease->deadline_ns);
  }
  return lease;
}

Result<Lease> AxisGate::RenewControl(const std::string& lease_id) {
  const std::lock_guard lock(mutex_);
  Result<Lease> lease = lease_.Renew(lease_id, clock_.NowNs());
  if (lease.ok()) {
    loop_.SetDeadline(lease->deadline_ns);
  }
  return lease;
}

Result<LoopStatus> AxisGate::ReleaseControl(const std::string& lease_id) {
  Posted posted;
  {
    const std::lock_guard lock(mutex_);
    if (std::optional<Refusal> refusal = lease_.Release(lease_id, clock_.NowNs())) {
      return *std::move(refusal);
    }
    posted = loop_.Stop();
  }
  return Await(posted, NotRendering);
}

Result<Posted> AxisGate::PostStart(const std::string& lease_id) {
  const std::lock_guard lock(mutex_);
  if (std::optional<Refusal> refusal = lease_.Check(lease_id, clock_.NowNs())) {
    return *std::move(refusal);
  }
  if (!description_.rendering_blocked_reason.empty()) {
    return Refusal{.code = RefusalCode::kFailedPrecondition,
                   .reason = kRenderingBlocked,
                   .message = description_.rendering_blocked_reason};
  }
  const LoopStatus& status = loop_.NewestStatus();
  if (status.state == State::kFault) {
    return InFault(status);
  }
  if (loop_.StopPending()) {
    return StillStopping(status);
  }
  if (status.state == State::kRendering || loop_.StartPending()) {
    return WrongState(status, "The axis renders already: set a mass, or stop it first.");
  }
  return loop_.Start();
}

Result<LoopStatus> AxisGate::StartRendering(const std::string& lease_id) {
  const Result<Posted> posted = PostStart(lease_id);
  if (!posted.ok()) {
    return posted.refusal();
  }
  const auto begun = [&posted](const LoopStatus& status) {
    return status.render_epoch >= posted->render_epoch && status.state != State::kFault;
  };
  Result<LoopStatus> answer = Await(
      *posted, [&begun](const LoopStatus& status) { return begun(status) || status.state == State::kFault; });
  if (!answer.ok() || begun(*answer)) {
    return answer;
  }
  {
    // Refused now must not become started later.
    const std::lock_guard lock(mutex_);
    if (loop_.render_epoch() == posted->render_epoch) {
      loop_.Stop();
    }
  }
  return answer->state == State::kFault
             ? InFault(*answer)
             : WrongState(*answer, "The axis did not begin to render: look at its state and ask again.");
}

Result<LoopStatus> AxisGate::StopRendering(const std::string& lease_id) {
  Posted posted;
  {
    const std::lock_guard lock(mutex_);
    if (std::optional<Refusal> refusal = lease_.Check(lease_id, clock_.NowNs())) {
      return *std::move(refusal);
    }
    posted = loop_.Stop();
  }
  return Await(posted, NotRendering);
}

std::optional<Refusal> AxisGate::CheckLease(const std::string& lease_id) {
  const std::lock_guard lock(mutex_);
  return lease_.Check(lease_id, clock_.NowNs());
}

Result<Posted> AxisGate::PostClearFault(const std::string& lease_id) {
  const std::lock_guard lock(mutex_);
  if (std::optional<Refusal> refusal = lease_.Check(lease_id, clock_.NowNs())) {
    return *std::move(refusal);
  }
  const LoopStatus& status = loop_.NewestStatus();
  if (status.state != State::kFault) {
    return WrongState(status, "There is no fault to clear: the axis is " + StateName(status.state) + ".");
  }
  return loop_.ClearFault(status.fault.number);
}

Result<LoopStatus> AxisGate::ClearFault(const std::string& lease_id) {
  const Result<Posted> posted = PostClearFault(lease_id);
  if (!posted.ok()) {
    return posted.refusal();
  }
  // A loop that still ramps down from the fault clears it afterwards.
  Result<LoopStatus> answer = Await(*posted, [&posted](const LoopStatus& status) {
    return status.state != State::kFault || status.fault.number > posted->cleared_fault_number;
  });
  if (answer.ok() && answer->state == State::kFault) {
    return InFault(*answer);
  }
  return answer;
}

Posted AxisGate::PostEmergencyStop() {
  const std::lock_guard lock(mutex_);
  return loop_.EmergencyStop();
}

Result<LoopStatus> AxisGate::AwaitEmergencyStop(const Posted& posted) {
  return Await(posted, [](const LoopStatus&) { return true; });
}

LoopStatus AxisGate::Status() {
  const std::lock_guard lock(mutex_);
  return loop_.NewestStatus();
}

double AxisGate::KeptMass() {
  const std::lock_guard lock(mutex_);
  return loop_.KeptMass();
}

std::string AxisGate::Controller() {
  const std::lock_guard lock(mutex_);
  return lease_.Holder(clock_.NowNs());
}

Result<LoopStatus> AxisGate::Await(const Posted& posted, const Predicate& done) {
  LoopStatus status;
  wait_([&] {
    status = Status();
    return status.settings_sequence >= posted.sequence && done(status);
  });
  if (status.settings_sequence >= posted.sequence) {
    return status;
  }
  const std::lock_guard lock(mutex_);
  loop_.Stop();
  return LoopSilent();
}

}  // namespace mwidth::gate
