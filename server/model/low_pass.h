// The filters behind the double difference d(k), or behind an accelerometer: what the loop computes, and the
// factors of what it computes.
//
// Each is one small type. Factors is its transfer function C(z), double difference included; the recurrence
// of Update takes its coefficients from there, so that what is certified is what runs. Update takes d(k) in
// m/s^2 or rad/s^2 and returns the estimate; Settle makes the filter what a long constant acceleration would
// have made it. Memory is what Update goes on from beside its last estimate, and Restore takes both up again.
// One thread; all Rt. The periods and cut-offs are those that Runs(kind, ..) allows.
#pragma once

#include <array>
#include <cmath>
#include <numbers>

#include "server/model/estimator_factors.h"

namespace mwidth::model {

/// Each filter has its own use for these, beginning with the first; the rest are 0. In units of acceleration,
/// or of its change in one tick.
using LowPassMemory = std::array<double, 3>;

/// No filter: what an accelerometer tells, as it is.
class DirectSignal {
 public:
  static double Update(double acceleration) noexcept { return acceleration; }
  static void Settle(double) noexcept {}
  static LowPassMemory Memory() noexcept { return {}; }
  static void Restore(double, const LowPassMemory&) noexcept {}
};

/// The paper's H(z) = (1 - a) z / (z - a), a = e^(-w0 T) (eq. 4):
///
///   a_hat(k) = a a_hat(k-1) + (1 - a) d(k)
class FirstOrderLowPass {
 public:
  static EstimatorFactors Factors(double period_s, double cutoff_hz) noexcept {
    const double decay = 2 * std::numbers::pi * cutoff_hz * period_s;
    const double gap = -std::expm1(-decay);
    return {.gain = gap,
            .half_rate_zero_pairs = 0,
            .lag_ticks = 1,
            .pole_count = 1,
            .poles = {{{.degree = 1, .circle = {gap, 2 - gap, std::exp(-decay)}}}}};
  }

  explicit FirstOrderLowPass(const EstimatorFactors& factors) noexcept
      : pole_(factors.poles[0].circle.turn), gain_(factors.gain) {}

  double Update(double difference) noexcept {
    acceleration_ = pole_ * acceleration_ + gain_ * difference;
    return acceleration_;
  }
  void Settle(double acceleration) noexcept { acceleration_ = acceleration; }
  static LowPassMemory Memory() noexcept { return {}; }
  void Restore(double acceleration, const LowPassMemory&) noexcept { acceleration_ = acceleration; }

 private:
  double pole_;
  double gain_;
  double acceleration_ = 0;
};

/// H(z) = (1 - a) / (z - a): the paper's filter, one tick late.
class LateFirstOrderLowPass {
 public:
  static EstimatorFactors Factors(double period_s, double cutoff_hz) noexcept {
    EstimatorFactors factors = FirstOrderLowPass::Factors(period_s, cutoff_hz);
    factors.lag_ticks = 2;
    return factors;
  }

  explicit LateFirstOrderLowPass(const EstimatorFactors& factors) noexcept : prompt_(factors) {}

  double Update(double difference) noexcept {
    const double late = filtered_;
    filtered_ = prompt_.Update(difference);
    return late;
  }
  void Settle(double acceleration) noexcept {
    prompt_.Settle(acceleration);
    filtered_ = acceleration;
  }
  /// The prompt value.
  LowPassMemory Memory() const noexcept { return {filtered_}; }
  void Restore(double, const LowPassMemory& memory) noexcept {
    prompt_.Settle(memory[0]);
    filtered_ = memory[0];
  }

 private:
  FirstOrderLowPass prompt_;
  double filtered_ = 0;
};

/// q z^2 / (w^2 + p w + q): a level that follows its input as a mass on a damped spring would,
///
///   rate(k) = rate(k-1) + q (input - level(k-1)) - (p - q) rate(k-1)      level(k) = level(k-1) + rate(k)
///
/// exactly, with q and p - q straight from the factor. Its rounding does not grow when the poles are slow
/// against the sample rate, as that of a direct form in powers of z does.
class SecondOrderLowPass {
 public:
  explicit SecondOrderLowPass(const PoleFactor& pole) noexcept
      : pull_(pole.circle.at_c / pole.Coefficients()[2]), drag_(pole.circle.turn / pole.Coefficients()[2]) {}

  double Update(double input) noexcept {
    rate_ += pull_ * (input - level_) - drag_ * rate_;
    level_ += rate_;
    return level_;
  }
  void Settle(double level) noexcept { Restore(level, 0); }
  double rate() const noexcept { return rate_; }
  void Restore(double level, double rate) noexcept {
    rate_ = rate;
    level_ = level;
  }

 private:
  double pull_;
  double drag_;
  double rate_ = 0;
  double level_ = 0;
};

/// Second-order Butterworth filter through the bilinear transform with the cut-off prewarped, the same as
/// scipy.signal.butter(2, 2 f0 T): with g = tan(w0 T/2) and sigma = w/(w + 2),
///
///   H = g^2 / (sigma^2 + sqrt(2) g sigma + g^2)
///
/// Two zeros at half the sample rate, where the double difference has most of the encoder's noise: a mean of
/// two samples, twice. The impulse-invariant and the matched transform have none there, and at cut-offs of a
/// tenth of the sample rate are no longer 3 dB down at theirs.
class ButterworthLowPass {
 public:
  static EstimatorFactors Factors(double period_s, double cutoff_hz) noexcept {
    const double g = std::tan(std::numbers::pi * cutoff_hz * period_s);
    const double square = g * g;
    return {.gain = square,
            .half_rate_zero_pairs = 1,
            .lag_ticks = 2,
            .pole_count = 1,
            .poles = {{{.degree = 2, .circle = {4 * square, -4, 2 * std::numbers::sqrt2 * g}}}}};
  }

  explicit ButterworthLowPass(const EstimatorFactors& factors) noexcept : section_(factors.poles[0]) {}

  double Update(double difference) noexcept {
    const double mean = 0.25 * (difference + 2 * last_ + before_);
    before_ = last_;
    last_ = difference;
    return section_.Update(mean);
  }
  void Settle(double acceleration) noexcept {
    last_ = before_ = acceleration;
    section_.Settle(acceleration);
  }
  /// The rate of the section, the difference last seen, and the one before.
  LowPassMemory Memory() const noexcept { return {section_.rate(), last_, before_}; }
  void Restore(double acceleration, const LowPassMemory& memory) noexcept {
    section_.Restore(acceleration, memory[0]);
    last_ = memory[1];
    before_ = memory[2];
  }

 private:
  SecondOrderLowPass section_;
  double last_ = 0;
  double before_ = 0;
};

/// Steady-state Kalman filter of a target whose acceleration changes by white steps from tick to tick, the
/// alpha-beta-gamma filter (Kalata 1984; Bar-Shalom, Li and Kirubarajan 2001), with the innovation r:
///
///   x += T v + T^2/2 a    v += T a    r = X(k) - x    x += alpha r    v += beta r/T    a += gamma r/T^2
///
/// From position to acceleration it is the double difference behind gamma z^3/((w + f)(w^2 + p w + q)), f q =
/// gamma, and run as such: first order, then second. (As written above, rounding would leave 1/(w0 T)^2 as
/// much.) The poles are those of the symmetric root locus
///
///   u^3 + lambda^2 (1 - u/4) = 0       u = |w|^2 = 4 sin^2(w T/2) on the unit circle
///
/// for the tracking index lambda, a cubic in u: the Riccati equation in closed form. Against the double
/// difference, u/T^2, the estimate has the size lambda / sqrt(u^3 + lambda^2 (1 - u/4)), so that lambda^2 =
/// u0^3 / (1 + u0/4) puts it 3 dB down at the cut-off. At slow cut-offs this is the third-order Butterworth
/// filter.
class KalmanLowPass {
 public:
  static EstimatorFactors Factors(double period_s, double cutoff_hz) noexcept;

  explicit KalmanLowPass(const EstimatorFactors& factors) noexcept
      : section_(factors.poles[0]),
        pole_(factors.poles[1].circle.turn),
        gain_(factors.poles[1].circle.at_c) {}

  double Update(double difference) noexcept {
    filtered_ = pole_ * filtered_ + gain_ * difference;
    return section_.Update(filtered_);
  }
  void Settle(double acceleration) noexcept {
    filtered_ = acceleration;
    section_.Settle(acceleration);
  }
  /// The rate of the section, and what goes into it.
  LowPassMemory Memory() const noexcept { return {section_.rate(), filtered_}; }
  void Restore(double acceleration, const LowPassMemory& memory) noexcept {
    section_.Restore(acceleration, memory[0]);
    filtered_ = memory[1];
  }

 private:
  SecondOrderLowPass section_;
  double pole_;
  double gain_;
  double filtered_ = 0;
};

}  // namespace mwidth::model
