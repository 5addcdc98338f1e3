// How acceleration is estimated from sampled positions: the paper's D(z) and H(z).
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace mwidth::model {

/// Double backward difference, then a first-order low-pass filter, for sample period T and cut-off w0 = 2 pi
/// f0:
///
///   D(z) = (z - 1)^2 / (T z)^2     H(z) = (1 - a) z / (z - a),  a = e^(-w0 T)     (eqs. 3, 4)
///
/// as difference equations, in this order of operations, so that whoever has the positions gets the same
/// bits:
///
///   v(k) = (x(k) - x(k-1)) / T     d(k) = (v(k) - v(k-1)) / T     a_hat(k) = a a_hat(k-1) + (1 - a) d(k)
///
/// Positions in m or rad, velocities and accelerations per s and s^2. One thread. All but the constructor is
/// Rt.
class AccelerationEstimator {
 public:
  /// The longest gap that Update bridges; after a longer one it starts afresh.
  static constexpr uint64_t kMaxBridgedPeriods = 64;

  /// `period_s` above 0; `cutoff_hz` above 0, at most 0.5 / period_s.
  AccelerationEstimator(double period_s, double cutoff_hz) noexcept
      : period_s_(period_s),
        pole_(std::exp(-2 * std::numbers::pi * cutoff_hz * period_s)),
        gain_(-std::expm1(-2 * std::numbers::pi * cutoff_hz * period_s)) {}

  /// As after a long rest at `position`: the next Update sees no step.
  void Reset(double position) noexcept {
    position_ = position;
    velocity_ = 0;
    acceleration_ = 0;
    primed_ = true;
  }

  /// The estimated acceleration, `periods` (at least 1) after the position before. The first position is a
  /// Reset.
  ///
  /// Positions that were missed are taken to lie on the straight line between their neighbours. The whole
  /// change of velocity then falls on the first missed sample and the filter decays over the rest, so that
  /// the sum of d(k) T is still the true change of velocity. Holding the old position instead would put a
  /// velocity of `periods` times the true one into the last sample, and the double difference would throw the
  /// motor.
  double Update(double position, uint64_t periods = 1) noexcept {
    if (!primed_ || periods > kMaxBridgedPeriods) {
      Reset(position);
      return acceleration_;
    }
    const double velocity = (position - position_) / (static_cast<double>(periods) * period_s_);
    acceleration_ = pole_ * acceleration_ + gain_ * ((velocity - velocity_) / period_s_);
    for (uint64_t i = 1; i < periods; ++i) {
      acceleration_ *= pole_;
    }
    position_ = position;
    velocity_ = velocity;
    return acceleration_;
  }

  double position() const noexcept { return position_; }
  /// First backward difference, unfiltered: the mean over the last period or gap.
  double velocity() const noexcept { return velocity_; }
  double acceleration() const noexcept { return acceleration_; }

 private:
  double period_s_;
  double pole_;
  double gain_;
  double position_ = 0;
  double velocity_ = 0;
  double acceleration_ = 0;
  bool primed_ = false;
};

}  // namespace mwidth::model
