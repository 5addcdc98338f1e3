// How the virtual mass goes from one value to another.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace mwidth::render {

/// A straight line in time from the mass that is to the mass that is wanted. The stable set is an interval
/// around zero, so a line between two admitted masses passes through stable ones only. Every value lies
/// between the ends, rounding included, and the last one is the target to the bit. One thread; all Rt.
class MassRamp {
 public:
  /// Longest ramp; a time that is not a number gets it too, being the gentlest.
  static constexpr double kLongestS = 10;

  explicit MassRamp(double period_s) noexcept : period_s_(period_s) {}

  /// Goes to `target` over `ramp_s`, from wherever it is. At least one tick, unless it is there already.
  void SetTarget(double target, double ramp_s) noexcept {
    start_ = mass_;
    target_ = target;
    const double bounded_s = std::isnan(ramp_s) ? kLongestS : std::clamp(ramp_s, 0.0, kLongestS);
    ticks_ = std::max<int64_t>(1, std::llround(bounded_s / period_s_));
    elapsed_ = mass_ == target_ ? ticks_ : 0;
  }

  /// Drops the mass to zero at once.
  void Cut() noexcept {
    mass_ = start_ = target_ = 0;
    elapsed_ = ticks_;
  }

  /// Lets `ticks` pass.
  void Advance(uint64_t ticks) noexcept {
    const auto left = static_cast<uint64_t>(ticks_ - elapsed_);
    if (left == 0) {
      return;
    }
    elapsed_ += static_cast<int64_t>(std::min(ticks, left));
    mass_ = elapsed_ == ticks_
                ? target_
                : start_ + (target_ - start_) * (static_cast<double>(elapsed_) / static_cast<double>(ticks_));
  }

  double mass() const noexcept { return mass_; }
  double target() const noexcept { return target_; }
  bool arrived() const noexcept { return elapsed_ == ticks_; }

 private:
  double period_s_;
  double mass_ = 0;
  double start_ = 0;
  double target_ = 0;
  int64_t ticks_ = 0;
  int64_t elapsed_ = 0;
};

}  // namespace mwidth::render
