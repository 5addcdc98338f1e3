// The one way to command an axis: lease, numbers, stability, state, then the mailbox, then the loop's answer.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "server/exchange/clock.h"
#include "server/exchange/crossing.h"
#include "server/gate/axis_description.h"
#include "server/gate/control_lease.h"
#include "server/gate/filter_request.h"
#include "server/gate/loop_settings.h"
#include "server/gate/mass_request.h"
#include "server/gate/refusal.h"
#include "server/gate/stability_gate.h"
#include "server/gate/wait_for_loop.h"
#include "server/model/certificate_cache.h"

namespace mwidth::gate {

/// Guards one axis. Any thread may call any function at any time.
///
/// One mutex covers the lease and the gate's end of the crossing, and is held for a check and a short copy
/// only: never while stability is computed or the loop is waited for, so that an emergency stop is posted at
/// once whatever else goes on. A command returns when the loop has acknowledged it. A loop that does not
/// within the wait (LOOP_SILENT) is told to stop rendering, should it wake up later.
class AxisGate {
 public:
  /// `crossing` and `clock` outlive the gate. Throws std::invalid_argument for a description with a loop that
  /// model::Validate refuses, or with limits that do not hold a mass of 0.
  AxisGate(AxisDescription description, exchange::Crossing& crossing, const exchange::Clock& clock,
           WaitForLoop wait = WaitUpToOneSecond);

  const AxisDescription& description() const { return description_; }
  /// Of the filter that is set; not null.
  std::shared_ptr<const StabilityGate> stability();

  /// Takes the lease; whatever an earlier holder left behind ends. Does not wait for the loop.
  Result<Lease> AcquireControl(const std::string& client_name, double ttl_s);
  /// Extends the lease, and with it the dead man's deadline of the loop. Does not wait for the loop.
  Result<Lease> RenewControl(const std::string& lease_id);
  /// Gives the lease back at once, then waits while a rendered mass ramps to zero.
  Result<exchange::LoopStatus> ReleaseControl(const std::string& lease_id);

  /// From IDLE or READY to RENDERING, with the mass kept by SetMass, or 0 where rendering has stopped or
  /// failed since. WRONG_STATE otherwise, or where the loop could not begin; RENDERING_BLOCKED as the
  /// description says.
  Result<exchange::LoopStatus> StartRendering(const std::string& lease_id);
  /// Ramps the mass to zero and waits for it. Granted in every state. The answer still says RENDERING where
  /// the ramp outlasts the wait.
  Result<exchange::LoopStatus> StopRendering(const std::string& lease_id);
  /// Checks in this order: lease, numbers, hard limits, stability, state. Rendered at once in RENDERING, kept
  /// for StartRendering in IDLE and READY, WRONG_STATE in FAULT and while a stop ramps down.
  Result<MassGrant> SetMass(const std::string& lease_id, const MassRequest& request);
  /// Checks in this order: lease, numbers, stability of the mass that is set with the new filter, state. At
  /// once in IDLE and READY; in RENDERING the loop takes the mass to zero, changes, and takes it back (0.2 s
  /// each way), and the answer waits for the change. WRONG_STATE in FAULT and while a stop ramps down. The
  /// filter stays until another is set, whoever has control.
  Result<FilterGrant> SetFilter(const std::string& lease_id, const FilterRequest& request);
  /// From FAULT to IDLE: clears the fault that is latched now, no later one. WRONG_STATE outside FAULT.
  Result<exchange::LoopStatus> ClearFault(const std::string& lease_id);

  /// Posts an emergency stop; needs no lease. Waits for nothing but the mutex's short copies.
  Posted PostEmergencyStop();
  /// Waits for the loop to have taken that emergency stop up.
  Result<exchange::LoopStatus> AwaitEmergencyStop(const Posted& posted);

  /// What the loop last did; all zero and IDLE before its first tick.
  exchange::LoopStatus Status();
  /// Name of the lease's holder; empty where nobody has control.
  std::string Controller();
  /// Samples that the record lost since the start.
  uint64_t dropped_samples() const { return crossing_.samples.dropped(); }
  /// What the loop's ticks took since it began.
  const exchange::TickStatistics& tick_statistics() const { return crossing_.tick_statistics; }

 private:
  using Predicate = std::function<bool(const exchange::LoopStatus&)>;

  std::optional<Refusal> CheckLease(const std::string& lease_id);
  Result<Posted> PostStart(const std::string& lease_id);
  /// Both answer none where what `judged` was asked about is no longer what is set: judge again.
  std::optional<Result<Posted>> PostMass(const std::string& lease_id, const MassRequest& request,
                                         const std::shared_ptr<const StabilityGate>& judged);
  std::optional<Result<Posted>> PostFilter(const std::string& lease_id, const FilterRequest& request,
                                           const std::shared_ptr<const StabilityGate>& judged,
                                           double judged_mass);
  /// Why a setting may not change in this state. Holds mutex_.
  std::optional<Refusal> CheckMaySet();
  double KeptMass();
  Result<Posted> PostClearFault(const std::string& lease_id);
  // Waits until the loop has acknowledged and is `done`. Answers the newest status if it has acknowledged at
  // all.
  Result<exchange::LoopStatus> Await(const Posted& posted, const Predicate& done);

  const AxisDescription description_;
  exchange::Crossing& crossing_;
  const exchange::Clock& clock_;
  const WaitForLoop wait_;
  /// Of the filters that were set, and of those that would admit a refused mass.
  const std::shared_ptr<model::CertificateCache> certificates_ = std::make_shared<model::CertificateCache>();

  std::mutex mutex_;
  std::shared_ptr<const StabilityGate> stability_;
  ControlLease lease_;
  LoopSettings loop_;
};

}  // namespace mwidth::gate
