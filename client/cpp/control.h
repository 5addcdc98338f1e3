// The right to command an axis, held for as long as an object lives.
#pragma once

#include <mwidth/v1/rendering.grpc.pb.h>

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <variant>

#include "client/cpp/failure.h"

namespace mwidth::client {

using Seconds = std::chrono::duration<double>;

/// Either the admitted mass with its margins, or the refusal with the range that would be admitted.
using MassAnswer = std::variant<v1::SetMassResponse, Refusal>;
/// Either the loop with its new filter, or the refusal of the mass that is set, judged with that filter.
using FilterAnswer = std::variant<v1::SetFilterResponse, Refusal>;

/// The control lease of an axis. A thread of its own renews it at a third of its time to live; the destructor
/// releases it, and the server then ramps the mass to zero. When this process dies or hangs, the renewals
/// stop and the server does the same: the lease is the dead-man switch.
///
/// All functions are safe from any thread, block for one round trip, and throw Error unless they say
/// otherwise.
class Control {
 public:
  /// Takes over a lease that was granted for a request sent at `sent`; Client::AcquireControl calls this.
  /// `call_timeout` bounds every call.
  Control(std::shared_ptr<v1::RenderingService::StubInterface> stub, std::string axis, v1::ControlLease lease,
          std::chrono::steady_clock::time_point sent, Seconds call_timeout);
  Control(const Control&) = delete;
  Control& operator=(const Control&) = delete;
  /// Releases the lease. Blocks for at most one second where the server does not answer; then the lease
  /// expires.
  ~Control();

  /// Enables the drive and renders from here on.
  v1::StartRenderingResponse StartRendering();
  /// Ramps the mass to zero and returns when the force is zero.
  v1::StopRenderingResponse StopRendering();
  /// Asks for a virtual mass (kg or kg m^2, negative feels lighter) and returns when the loop has taken it
  /// up, at the start of its ramp; an unset `ramp` means the server's own. A refused mass is an answer; every
  /// other failure (no lease, not finite) throws.
  MassAnswer SetMass(double mass, std::optional<Seconds> ramp = std::nullopt);
  /// The answer that SetMass would give. Changes nothing.
  MassAnswer ValidateMass(double mass);
  /// Asks for another filter of the acceleration and returns when the loop runs it: `estimator`, unspecified
  /// for the running one, with its cut-off in Hz, above 0 and at most half the sample rate. The mass that is
  /// set stays; while it is rendered the loop takes it to zero, changes, and takes it back. A filter that
  /// this mass is not admitted with is a refusal, an answer; every other failure throws.
  FilterAnswer SetFilter(v1::EstimatorKind estimator, double cutoff_hz);
  /// The answer that SetFilter would give. Changes nothing.
  FilterAnswer ValidateFilter(v1::EstimatorKind estimator, double cutoff_hz);
  /// From FAULT to IDLE, once its cause is gone.
  v1::ClearFaultResponse ClearFault();

  /// Why the lease is gone, if it is: another client has it, or no renewal got through within its time to
  /// live. Once lost it stays lost. Does not block.
  std::optional<Error> Loss() const;
  /// Blocks until the lease is lost, `stop` is requested or `timeout` has passed; true when it is lost.
  bool WaitForLoss(std::stop_token stop, Seconds timeout);

 private:
  FilterAnswer RequestFilter(v1::EstimatorKind estimator, double cutoff_hz, bool validate_only);
  void RenewUntilStopped(const std::stop_token& stop);
  void Release() noexcept;

  const std::shared_ptr<v1::RenderingService::StubInterface> stub_;
  const std::string axis_;
  const v1::ControlLease lease_;
  const std::chrono::nanoseconds ttl_;
  const Seconds call_timeout_;

  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<Error> loss_;
  // Written by the constructor, then by the renewal thread alone.
  std::chrono::steady_clock::time_point valid_until_;
  // Last: it uses everything above and joins before any of it goes.
  std::jthread renewal_;
};

}  // namespace mwidth::client
