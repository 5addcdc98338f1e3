#include "server/model/estimator_range.h"

#include <numbers>

namespace mwidth::model {

FirstOrderRange::FirstOrderRange(double period_s, double cutoff_hz) noexcept {
  const Interval pi{std::numbers::pi, Above(std::numbers::pi)};
  const Interval per_tick = 2 * (pi * Exactly(cutoff_hz) * Exactly(period_s));
  gap_ = per_tick * MeanDecay(per_tick);
  pole_ = Exp(-per_tick);
}

CircleRange FirstOrderRange::Over(const Arc& arc) const noexcept {
  // f conj(w + f) / |w + f|^2 with w + f = f - 2 x + j sin(t): both parts are monotonic in x.
  const auto size = [this](double x) { return Square(gap_) + 4 * (pole_ * Exactly(x)); };
  const Interval low_size = size(arc.x.lo);
  const Interval high_size = size(arc.x.hi);
  const auto re = [this](double x, const Interval& e) { return gap_ * (gap_ - 2 * Exactly(x)) / e; };
  return {.re = {re(arc.x.hi, high_size).lo, re(arc.x.lo, low_size).hi},
          .im = {-(gap_ / low_size).hi, -(gap_ / high_size).lo}};
}

}  // namespace mwidth::model
