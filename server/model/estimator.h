// How acceleration is estimated from sampled positions, or had from an accelerometer: as the loop computes
// it, and as the model sees it.
#pragma once

#include <cstdint>
#include <variant>

#include "server/model/estimator_factors.h"
#include "server/model/estimator_kind.h"
#include "server/model/low_pass.h"

namespace mwidth::model {

/// All that an AccelerationEstimator goes on from, beside its period and its filter.
struct EstimatorMemory {
  double position = 0;
  double velocity = 0;
  double acceleration = 0;
  LowPassMemory low_pass{};
  /// False until it has seen a position.
  bool primed = false;
};

/// C(z) of what AccelerationEstimator runs from positions. Precondition: Runs(kind, period_s, cutoff_hz), and
/// not IsAccelerometer(kind), of which accelerometer.h has the factors. Any thread. Rt.
EstimatorFactors FactorsOf(EstimatorKind kind, double period_s, double cutoff_hz) noexcept;

/// Double backward difference (eq. 3), then a low-pass filter, for sample period T:
///
///   v(k) = (x(k) - x(k-1)) / T     d(k) = (v(k) - v(k-1)) / T     a_hat(k) = filter of d(k)
///
/// in this order of operations, so that whoever has the positions gets the same bits; the filters are in
/// low_pass.h. With an accelerometer d(k) is what that told with the position instead. Positions in m or rad,
/// velocities and accelerations per s and s^2. One thread. Rt, copies and construction included.
class AccelerationEstimator {
 public:
  /// The longest gap that Update bridges; after a longer one it starts afresh.
  static constexpr uint64_t kMaxBridgedPeriods = 64;

  /// Precondition: Runs(kind, period_s, cutoff_hz).
  AccelerationEstimator(double period_s, double cutoff_hz,
                        EstimatorKind kind = EstimatorKind::kFilteredDifference) noexcept;

  /// Another estimator in the place of this one, as if it had always run and the acceleration had long been
  /// the present estimate: neither position nor velocity nor acceleration jumps. Precondition: Runs(kind,
  /// period_s, cutoff_hz) with the period of this one.
  AccelerationEstimator ChangedTo(EstimatorKind kind, double cutoff_hz) const noexcept;

  /// As after a long rest at `position`: the next Update sees no step.
  void Reset(double position) noexcept {
    position_ = position;
    velocity_ = 0;
    Settle(0);
    primed_ = true;
  }

  /// The estimated acceleration, `periods` (at least 1) after the position before. The first position is a
  /// Reset.
  ///
  /// Positions that were missed are taken to lie on the straight line between their neighbours. The whole
  /// change of velocity then falls on the first missed sample and the filter goes on without over the rest,
  /// so that the sum of d(k) T is still the true change of velocity. Holding the old position instead would
  /// put a velocity of `periods` times the true one into the last sample, and the double difference would
  /// throw the motor.
  ///
  /// `sensed` is what the accelerometer told with the position, m/s^2 or rad/s^2; of no account without one.
  /// It stands for what it would have told in the periods missed.
  double Update(double position, uint64_t periods = 1, double sensed = 0) noexcept {
    if (!primed_ || periods > kMaxBridgedPeriods) {
      Reset(position);
      if (senses_) {
        Settle(sensed);
      }
      return acceleration_;
    }
    const double velocity = (position - position_) / (static_cast<double>(periods) * period_s_);
    Filter(senses_ ? sensed : (velocity - velocity_) / period_s_);
    for (uint64_t i = 1; i < periods; ++i) {
      Filter(senses_ ? sensed : 0);
    }
    position_ = position;
    velocity_ = velocity;
    return acceleration_;
  }

  EstimatorMemory Memory() const noexcept {
    EstimatorMemory memory{
        .position = position_, .velocity = velocity_, .acceleration = acceleration_, .primed = primed_};
    OnLowPass(low_pass_, [&memory](const auto& low_pass) { memory.low_pass = low_pass.Memory(); });
    return memory;
  }

  /// Goes on from where another of the same period and filter had that Memory(), bit for bit.
  void Restore(const EstimatorMemory& memory) noexcept {
    position_ = memory.position;
    velocity_ = memory.velocity;
    acceleration_ = memory.acceleration;
    primed_ = memory.primed;
    OnLowPass(low_pass_,
              [&memory](auto& low_pass) { low_pass.Restore(memory.acceleration, memory.low_pass); });
  }

  double position() const noexcept { return position_; }
  /// First backward difference, unfiltered: the mean over the last period or gap.
  double velocity() const noexcept { return velocity_; }
  double acceleration() const noexcept { return acceleration_; }

 private:
  using LowPass =
      std::variant<FirstOrderLowPass, LateFirstOrderLowPass, ButterworthLowPass, KalmanLowPass, DirectSignal>;

  static LowPass MakeLowPass(EstimatorKind kind, double period_s, double cutoff_hz) noexcept;
  // std::visit, which may throw, without its throw.
  template <typename Variant, typename Function>
  static void OnLowPass(Variant& low_pass, const Function& function) noexcept {
    if (auto* first_order = std::get_if<FirstOrderLowPass>(&low_pass)) {
      function(*first_order);
    } else if (auto* late = std::get_if<LateFirstOrderLowPass>(&low_pass)) {
      function(*late);
    } else if (auto* butterworth = std::get_if<ButterworthLowPass>(&low_pass)) {
      function(*butterworth);
    } else if (auto* kalman = std::get_if<KalmanLowPass>(&low_pass)) {
      function(*kalman);
    } else if (auto* direct = std::get_if<DirectSignal>(&low_pass)) {
      function(*direct);
    }
  }
  void Filter(double difference) noexcept {
    OnLowPass(low_pass_, [this, difference](auto& low_pass) { acceleration_ = low_pass.Update(difference); });
  }
  void Settle(double acceleration) noexcept {
    acceleration_ = acceleration;
    OnLowPass(low_pass_, [acceleration](auto& low_pass) { low_pass.Settle(acceleration); });
  }

  double period_s_;
  LowPass low_pass_;
  double position_ = 0;
  double velocity_ = 0;
  double acceleration_ = 0;
  bool senses_ = false;
  bool primed_ = false;
};

}  // namespace mwidth::model
