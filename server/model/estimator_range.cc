#include "server/model/estimator_range.h"

#include <algorithm>
#include <numbers>

#include "server/model/estimator.h"

namespace mwidth::model {
namespace {

// The proof is for the coefficients that the loop runs with: these doubles, and what its recurrence rounds
// where it divides two of them. 64 units are far more than that, and far less than any proof gives away.
constexpr double kCoefficientUlps = 64;

Interval Around(double x, double ulps) noexcept { return {Below(x, ulps), Above(x, ulps)}; }

// One delay z^-1, or one of its inverse.
CircleRange Later(const Arc& arc) noexcept { return {arc.cosine, Exactly(-1)}; }
CircleRange Earlier(const Arc& arc) noexcept { return {arc.cosine, Exactly(1)}; }

CircleRange Scale(const Interval& factor, const CircleRange& a) noexcept {
  return {factor * a.re, factor * a.im};
}

Interval DecayPerTick(double period_s, double cutoff_hz) noexcept {
  const Interval pi{std::numbers::pi, Above(std::numbers::pi)};
  return 2 * (pi * Exactly(cutoff_hz) * Exactly(period_s));
}

FirstOrderRange PapersFilter(const Interval& per_tick) noexcept {
  return {per_tick * MeanDecay(per_tick), Exp(-per_tick)};
}

}  // namespace

CircleRange FirstOrderRange::Over(const Arc& arc) const noexcept {
  // f conj(w + f) / |w + f|^2 with w + f = f - 2 x + j sin(t): both parts are monotonic in x.
  const auto size = [this](double x) { return Square(gap_) + 4 * (pole_ * Exactly(x)); };
  const Interval low_size = size(arc.x.lo);
  const Interval high_size = size(arc.x.hi);
  const auto re = [this](double x, const Interval& e) { return gap_ * (gap_ - 2 * Exactly(x)) / e; };
  return {.re = {re(arc.x.hi, high_size).lo, re(arc.x.lo, low_size).hi},
          .im = {-(gap_ / low_size).hi, -(gap_ / high_size).lo}};
}

SecondOrderRange::SecondOrderRange(const PoleFactor& factor, double ulps) noexcept
    : at_c_(Around(factor.circle.at_c, ulps)),
      slope_(Around(factor.circle.at_s, ulps) - at_c_),
      turn_(Around(factor.circle.turn, ulps)),
      turn_squared_(Square(turn_)),
      linear_(2 * (at_c_ * slope_) + 4 * turn_squared_),
      square_(Square(slope_) - 4 * turn_squared_) {}

Interval SecondOrderRange::SizeOver(const Interval& x) const noexcept {
  const Interval derivative = linear_ + 2 * (square_ * x);
  const Interval low = SizeAt(Exactly(x.lo));
  const Interval high = SizeAt(Exactly(x.hi));
  if (derivative.lo >= 0) {
    return {low.lo, high.hi};
  }
  if (derivative.hi <= 0) {
    return {high.lo, low.hi};
  }
  // From either end no further than the steepest descent, and nowhere more than the terms allow.
  const Interval terms = SizeAt(x);
  const double descent = Above((x.hi - x.lo) * std::max(-derivative.lo, derivative.hi));
  return {std::max(terms.lo, Below(std::min(low.lo, high.lo) - descent)), terms.hi};
}

CircleRange SecondOrderRange::Over(const Arc& arc) const noexcept {
  const Interval& x = arc.x;
  const Interval size = SizeOver(x);
  Interval re = PAt(x) / size;
  // The numerator of the derivative of p/|B|^2.
  const Interval derivative =
      -(at_c_ * (at_c_ * slope_ + 4 * turn_squared_)) - square_ * x * (2 * at_c_ + slope_ * x);
  const auto at = [this](double end) { return PAt(Exactly(end)) / SizeAt(Exactly(end)); };
  if (derivative.hi <= 0) {
    re = {at(x.hi).lo, at(x.lo).hi};
  } else if (derivative.lo >= 0) {
    re = {at(x.lo).lo, at(x.hi).hi};
  }
  return Scale(at_c_, {re, -(turn_ / size)});
}

EstimatorRange::EstimatorRange(EstimatorKind kind, double period_s, double cutoff_hz,
                               double accelerometer_bandwidth_hz) noexcept
    : kind_(kind) {
  if (IsAccelerometer(kind)) {
    sensor_rate_ = DecayPerTick(period_s, accelerometer_bandwidth_hz);
    sensor_ = PapersFilter(sensor_rate_);
    first_order_ = PapersFilter(DecayPerTick(period_s, cutoff_hz));
    return;
  }
  if (kind == EstimatorKind::kFilteredDifference || kind == EstimatorKind::kLateFilteredDifference) {
    first_order_ = PapersFilter(DecayPerTick(period_s, cutoff_hz));
    return;
  }
  const EstimatorFactors factors = FactorsOf(kind, period_s, cutoff_hz);
  second_order_ = SecondOrderRange(factors.poles[0], kCoefficientUlps);
  if (kind == EstimatorKind::kKalman) {
    const CircleFactor& pole = factors.poles[1].circle;
    first_order_ = {Around(pole.at_c, kCoefficientUlps), Around(pole.turn, kCoefficientUlps)};
  }
}

CircleRange EstimatorRange::Over(const Arc& arc) const noexcept {
  switch (kind_) {
    case EstimatorKind::kLateFilteredDifference:
      return Multiply(first_order_.Over(arc), Later(arc), arc);
    case EstimatorKind::kButterworth:
      // g^2 (z + 1)^2/(z B) = 4 c g^2/B, and B(1) = 4 g^2.
      return Scale(1 - arc.x, Multiply(second_order_.Over(arc), Later(arc), arc));
    case EstimatorKind::kKalman:
      return Multiply(Multiply(second_order_.Over(arc), first_order_.Over(arc), arc), Earlier(arc), arc);
    case EstimatorKind::kAccelerometer:
      return sensor_.Over(arc);
    case EstimatorKind::kFilteredAccelerometer:
      return Multiply(Multiply(sensor_.Over(arc), first_order_.Over(arc), arc), Earlier(arc), arc);
    default:
      return first_order_.Over(arc);
  }
}

}  // namespace mwidth::model
