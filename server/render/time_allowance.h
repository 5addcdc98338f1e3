// What may happen now and then, but must not go on.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace mwidth::render {

/// The time that something may take of every window that slides over the ticks. Adding up over a window is
/// what catches that which comes and goes: a force that touches its limit once in every period of an
/// oscillation, a drive that answers every other tick.
///
/// The window slides in steps of 1/32 of its length and holds up to two steps more than its length, so what
/// is spent is never less than in the exact window. One thread, no allocation; all Rt.
class TimeAllowance {
 public:
  TimeAllowance(double period_s, double window_s, double allowed_s) noexcept
      : period_s_(period_s),
        allowed_ticks_(TicksOf(allowed_s, period_s)),
        step_ticks_((WindowTicks(window_s, period_s) + kMaxSteps - 1) / kMaxSteps),
        steps_((WindowTicks(window_s, period_s) + step_ticks_ - 1) / step_ticks_ + 1) {}

  /// Nothing is spent.
  void Reset() noexcept {
    spent_in_step_ = {};
    spent_ticks_ = 0;
    ticks_in_step_ = 0;
  }

  /// Lets `ticks` pass, all of them spent or none.
  void Pass(uint64_t ticks, bool spent) noexcept {
    // Beyond the whole window nothing changes any more, and the loop must be bounded.
    ticks = std::min(ticks, step_ticks_ * (steps_ + 1));
    while (ticks > 0) {
      if (ticks_in_step_ == step_ticks_) {
        BeginStep();
      }
      const uint64_t now = std::min(ticks, step_ticks_ - ticks_in_step_);
      ticks_in_step_ += now;
      ticks -= now;
      if (spent) {
        spent_in_step_[step_] += now;
        spent_ticks_ += now;
      }
    }
  }

  bool Exceeded() const noexcept { return spent_ticks_ > allowed_ticks_; }
  double spent_s() const noexcept { return static_cast<double>(spent_ticks_) * period_s_; }
  double allowed_s() const noexcept { return static_cast<double>(allowed_ticks_) * period_s_; }

 private:
  static constexpr uint64_t kMaxSteps = 32;

  static uint64_t TicksOf(double time_s, double period_s) noexcept {
    return static_cast<uint64_t>(std::llround(std::max(0.0, time_s) / period_s));
  }

  static uint64_t WindowTicks(double window_s, double period_s) noexcept {
    return std::max<uint64_t>(1, TicksOf(window_s, period_s));
  }

  void BeginStep() noexcept {
    step_ = (step_ + 1) % steps_;
    spent_ticks_ -= spent_in_step_[step_];
    spent_in_step_[step_] = 0;
    ticks_in_step_ = 0;
  }

  double period_s_;
  uint64_t allowed_ticks_;
  uint64_t step_ticks_;
  // Of the window, and one more: the one that is being filled.
  uint64_t steps_;
  std::array<uint64_t, kMaxSteps + 1> spent_in_step_{};
  std::size_t step_ = 0;
  uint64_t spent_ticks_ = 0;
  uint64_t ticks_in_step_ = 0;
};

}  // namespace mwidth::render
