// Forces on their way from the loop to the motor.
#pragma once

#include <array>
#include <cstddef>

namespace mwidth::model {

/// A staircase of forces that acts late by a whole number of ticks and a fraction of one: during tick k,
/// F_a(k
/// - ticks - 1) until the fraction has passed, then F_a(k - ticks). All but the constructor is Rt.
class DelayedForce {
 public:
  /// `delay_periods` from 0 to 3.
  explicit DelayedForce(double delay_periods) noexcept
      : ticks_(static_cast<std::size_t>(delay_periods)),
        fraction_(delay_periods - static_cast<double>(ticks_)) {}

  /// Of a tick, below 1.
  double fraction() const noexcept { return fraction_; }

  /// All forces become 0, also those on their way.
  void Reset() noexcept {
    command_ = older_ = newer_ = 0;
    on_the_way_.fill(0);
  }
  /// F_a(k), until the next command.
  void Command(double force) noexcept { command_ = force; }
  /// Starts tick k: now older() acts, and newer() from the fraction on.
  void Start() noexcept {
    older_ = newer_;
    if (ticks_ == 0) {
      newer_ = command_;
      return;
    }
    // A ring, not a shift: moving what was stored a moment ago in other widths stalls the processor.
    on_the_way_[tick_ % kRing] = command_;
    newer_ = on_the_way_[(tick_ - ticks_) % kRing];
    ++tick_;
  }
  double older() const noexcept { return older_; }
  double newer() const noexcept { return newer_; }

 private:
  /// F_a(k) to F_a(k - 3).
  static constexpr std::size_t kRing = 4;

  std::size_t ticks_;
  double fraction_;
  std::size_t tick_ = 0;
  double command_ = 0;
  double older_ = 0;
  double newer_ = 0;
  std::array<double, kRing> on_the_way_{};
};

}  // namespace mwidth::model
