// What the gate has told the loop, and how it tells it more.
#pragma once

#include <cstdint>

#include "server/exchange/crossing.h"

namespace mwidth::gate {

/// What to look for in LoopStatus once something was posted.
struct Posted {
  uint64_t sequence = 0;
  uint64_t render_epoch = 0;
  uint64_t cleared_fault_number = 0;
};

/// The gate's end of the crossing: the only writer of its settings and the only reader of its status.
/// Settings are posted whole and the newest wins, so each function changes its part of what was posted before
/// and posts it all. Not thread-safe; nothing waits.
class LoopSettings {
 public:
  /// `filter` is what the loop is configured with; `critical_hz`, as in exchange::Settings, belongs to it.
  LoopSettings(exchange::Crossing& crossing, const exchange::Filter& filter, double critical_hz)
      : crossing_(crossing) {
    settings_.filter = filter;
    settings_.critical_hz = critical_hz;
  }

  /// What the loop last did; all zero and IDLE before its first tick.
  const exchange::LoopStatus& NewestStatus();

  /// Moves the dead man's deadline of the loop.
  Posted SetDeadline(int64_t lease_deadline_ns);
  /// Renders `mass` from now on, or keeps it for Start.
  Posted SetMass(double mass, double ramp_s);
  /// Estimates the acceleration with `filter` from now on. A rendered mass goes to zero before the loop
  /// changes, and comes back afterwards; a kept mass that is void is forgotten.
  Posted SetFilter(const exchange::Filter& filter, double critical_hz);
  /// The mass that SetMass rendered or kept; 0 where there is none, or it is void.
  double KeptMass();
  /// Begins to render the mass that SetMass kept. A kept mass is void, and 0 in its place, once a rendering
  /// has ended or a fault has come since: a person must not meet a mass that was asked for in another
  /// situation.
  Posted Start();
  /// Ramps the mass to zero, and forgets it.
  Posted Stop();
  Posted EmergencyStop();
  /// Clears the faults up to `fault_number`; the axis does not render afterwards.
  Posted ClearFault(uint64_t fault_number);

  /// True after Start until the loop has begun.
  bool StartPending();
  /// True after Stop while the loop still renders.
  bool StopPending();
  uint64_t render_epoch() const { return settings_.render_epoch; }

 private:
  bool MassIsVoid();
  void ForgetMass();
  Posted Post();

  exchange::Crossing& crossing_;
  exchange::Settings settings_;
  exchange::LoopStatus status_;
  // The loop's counters when the mass was last set.
  uint64_t renderings_ended_at_mass_ = 0;
  uint64_t fault_number_at_mass_ = 0;
};

}  // namespace mwidth::gate
