// Whether the drive is given the force that the mass asks for.
#pragma once

#include <cstdint>

#include "server/render/breach.h"
#include "server/render/limits.h"
#include "server/render/loop_config.h"
#include "server/render/time_allowance.h"

namespace mwidth::render {

/// A force that is clamped is not M a_hat any more, and the loop not the one that was certified: by the force
/// limit the mass is less, by the slew limit it is late. Briefly, that does no harm; what goes on is either a
/// mass that is too large for the motor, or an oscillation that only the clamp keeps from growing. The loop's
/// thread; all Rt.
class ForceWatch {
 public:
  explicit ForceWatch(const LoopConfig& config) noexcept
      : saturation_(config.period_s, config.watch.window_s, config.watch.saturation_s),
        slew_(config.period_s, config.watch.window_s, config.watch.slew_s) {}

  /// The last force acted on over the ticks that were missed.
  void Hold(uint64_t missed_ticks) noexcept {
    saturation_.Pass(missed_ticks, last_.saturated);
    slew_.Pass(missed_ticks, last_.slew_limited);
  }
  /// The force of this tick.
  void Follow(const ForceCommand& force) noexcept {
    last_ = force;
    saturation_.Pass(1, force.saturated);
    slew_.Pass(1, force.slew_limited);
    saturated_ticks_ += force.saturated ? 1 : 0;
    slew_limited_ticks_ += force.slew_limited ? 1 : 0;
  }
  /// Nothing is clamped where nothing has been rendered yet.
  void Begin() noexcept {
    last_ = {};
    saturation_.Reset();
    slew_.Reset();
  }

  Breach Judge() const noexcept {
    if (saturation_.Exceeded()) {
      return {exchange::Fault::kForceSaturation, saturation_.spent_s(), saturation_.allowed_s()};
    }
    if (slew_.Exceeded()) {
      return {exchange::Fault::kForceSlew, slew_.spent_s(), slew_.allowed_s()};
    }
    return {};
  }

  /// Ticks with a clamped force since the loop was made.
  uint64_t saturated_ticks() const noexcept { return saturated_ticks_; }
  uint64_t slew_limited_ticks() const noexcept { return slew_limited_ticks_; }

 private:
  TimeAllowance saturation_;
  TimeAllowance slew_;
  ForceCommand last_;
  uint64_t saturated_ticks_ = 0;
  uint64_t slew_limited_ticks_ = 0;
};

}  // namespace mwidth::render
