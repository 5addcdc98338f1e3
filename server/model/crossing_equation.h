// The equation of crossing.h for one loop: at a point of the unit circle, and as a polynomial.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "server/model/accelerometer.h"
#include "server/model/estimator_factors.h"
#include "server/model/plant.h"
#include "server/model/unit_circle.h"

namespace mwidth::model {

/// L = M' W of crossing.h. All functions are Rt; any thread.
class CrossingEquation {
 public:
  CrossingEquation(const SampledPlant& plant, const EstimatorFactors& estimator, double moving_mass) noexcept;
  /// With an accelerometer.
  CrossingEquation(const SampledPlant& plant, const SampledAcceleration& acceleration,
                   const EstimatorFactors& factors, double moving_mass) noexcept;

  /// W without its gain and its zeros at z = -1: (hold[0] + hold[1]/z + hold[2]/z^2) times the factors, one
  /// of which is the numerator of an accelerometer.
  CircleValue W(const CirclePoint& at) const noexcept {
    const double cosine = at.c - at.s;
    const auto& n = hold_;
    CircleValue value{n[0] + n[1] * cosine, -n[1], std::abs(n[0]) + std::abs(n[1]), std::abs(n[1])};
    if (n[2] != 0) {
      value.re += n[2] * (cosine * cosine - 4 * at.s * at.c);
      value.im -= n[2] * 2 * cosine;
      value.re_size += std::abs(n[2]);
      value.im_size += 2 * std::abs(n[2]);
    }
    for (int i = 0; i < factor_count_; ++i) {
      value = Times(value, factors_[static_cast<size_t>(i)], at);
    }
    return value;
  }

  /// L, the left side that is to be M' W.
  CircleValue Left(const CirclePoint& at) const noexcept {
    const double u = 4 * at.s;
    const double q = plant_.static_gap;
    if (senses_acceleration_) {
      return {-u * (0.5 * (q - u) + plant_.loss), q - u, u * (0.5 * (q + u) + plant_.loss), q + u};
    }
    return {q - u * (1 - plant_.loss / 2), plant_.loss, q + u, plant_.loss};
  }

  /// Im(L conj(W)) / sin(t): zero where one mass satisfies both real equations. Where nothing is lost in a
  /// loop without an accelerometer, Y: the other factor's root is at rest, and CrossingsOf knows it.
  double Disagreement(const CirclePoint& at) const noexcept {
    const CircleValue w = W(at);
    if (senses_acceleration_) {
      const CircleValue left = Left(at);
      return left.re * w.im - left.im * w.re;
    }
    if (plant_.loss == 0) {
      return w.im;
    }
    return (plant_.static_gap - 4 * at.s) * w.im + plant_.loss * (2 * at.s * w.im - w.re);
  }

  /// The mass at a crossing, from whichever of the two equations suffers less from cancellation.
  double MassAt(const CirclePoint& at) const noexcept {
    const CircleValue w = W(at);
    const CircleValue left = Left(at);
    // Size over value is how many times its rounding a number carries; compared without dividing.
    const double lost_in_im =
        std::max(w.im_size * std::abs(left.im), std::abs(w.im) * left.im_size) * std::abs(w.re * left.re);
    const double lost_in_re =
        std::max(w.re_size * std::abs(left.re), std::abs(w.re) * left.re_size) * std::abs(w.im * left.im);
    const bool from_im = lost_in_im <= lost_in_re && left.im != 0;
    return MassFor(from_im ? left.im / w.im : left.re / w.re, at);
  }

  /// At z = -1 everything is real: one equation, no condition. Infinite where C(-1) = 0.
  double MassAtHalfSampleRate() const noexcept { return MassFor(Left({1, 0}).re / W({1, 0}).re, {1, 0}); }

  /// Coefficients of Disagreement as a form. Returns its degree.
  int DisagreementForm(Form& form) const noexcept;

 private:
  // Estimator's poles, whole ticks of delay, and two more where a numerator has them.
  static constexpr size_t kMaxFactors = EstimatorFactors::kMaxPoles + 5;

  void Append(const CircleFactor& factor) noexcept {
    factors_[static_cast<size_t>(factor_count_++)] = factor;
  }

  // M from M' |B|^2.
  double MassFor(double ratio, const CirclePoint& at) const noexcept {
    double mass = mass_scale_ * ratio;
    for (const PoleFactor& pole : estimator_) {
      mass *= pole.SizeSquared(at);
    }
    for (int i = 0; i < estimator_.half_rate_zero_pairs; ++i) {
      mass /= 4 * at.c;
    }
    return mass / (4 * at.s);
  }

  void AppendEstimator() noexcept;

  SampledPlant plant_;
  EstimatorFactors estimator_;
  double mass_scale_;
  // Of the plant; 1 where there is an accelerometer, whose numerator is the first factor.
  std::array<double, 3> hold_;
  bool senses_acceleration_;
  std::array<CircleFactor, kMaxFactors> factors_;
  int factor_count_ = 0;
};

}  // namespace mwidth::model
