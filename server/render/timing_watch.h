// Whether the loop keeps the time that the stability model counts on.
#pragma once

#include <cstdint>
#include <optional>

#include "server/render/breach.h"
#include "server/render/loop_config.h"
#include "server/render/time_allowance.h"

namespace mwidth::render {

/// Deadlines that are missed, and forces that come late. The loop's thread; all Rt.
class TimingWatch {
 public:
  explicit TimingWatch(const LoopConfig& config) noexcept
      : max_missed_ticks_(config.max_missed_ticks),
        max_consecutive_(config.watch.max_consecutive_overruns),
        delay_limit_s_(config.watch.delay_limit_s),
        late_(config.period_s, config.watch.window_s, config.watch.late_s) {}

  /// A tick begins, after so many were missed. `loop_delay_ns`: from the position of the tick before to its
  /// force, where both were exchanged with the drive.
  void Wake(uint64_t missed_ticks, std::optional<int64_t> loop_delay_ns) noexcept {
    missed_ticks_ = missed_ticks;
    consecutive_ = missed_ticks > 0 ? consecutive_ + 1 : 0;
    const double delay_s = static_cast<double>(loop_delay_ns.value_or(0)) * 1e-9;
    const bool late = delay_s > delay_limit_s_;
    if (late) {
      late_delay_s_ = delay_s;
    }
    // A force that comes late acts on over the ticks that were missed.
    late_.Pass(1 + missed_ticks, late);
  }
  /// Forgets the late forces of the past.
  void Begin() noexcept { late_.Reset(); }

  Breach JudgeOverrun() const noexcept {
    if (missed_ticks_ > max_missed_ticks_) {
      return {exchange::Fault::kOverrun, static_cast<double>(missed_ticks_),
              static_cast<double>(max_missed_ticks_)};
    }
    if (consecutive_ > max_consecutive_) {
      return {exchange::Fault::kRepeatedOverrun, static_cast<double>(consecutive_),
              static_cast<double>(max_consecutive_)};
    }
    return {};
  }
  /// Its figures: the newest delay that was too long, and what is certified.
  Breach JudgeDelay() const noexcept {
    if (late_.Exceeded()) {
      return {exchange::Fault::kLoopDelay, late_delay_s_, delay_limit_s_};
    }
    return {};
  }

 private:
  const uint64_t max_missed_ticks_;
  const uint64_t max_consecutive_;
  const double delay_limit_s_;
  TimeAllowance late_;
  uint64_t missed_ticks_ = 0;
  uint64_t consecutive_ = 0;
  double late_delay_s_ = 0;
};

}  // namespace mwidth::render
