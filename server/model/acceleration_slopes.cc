#include "server/model/acceleration_slopes.h"

#include <algorithm>
#include <cmath>

#include "server/model/sloped.h"

namespace mwidth::model {
namespace {

using Number = Sloped<double>;
using Range = Sloped<Interval>;

// accelerometer_response.h with slopes, and with d in place of spring_loss.
struct Response {
  Number impulse;
  Number step;
  Number slope;
  Number held;
  Number lost;
  Number after_step;
  Number after_ramp;
};

struct Rates {
  Number damping;
  Number stiffness;
  double sensor;
};

constexpr Number kOne{1, 0, 0};
// Products of time and rates below which each term of the series is less than 1/n of the one before, and the
// terms that are taken: what is left is below 1e-18.
constexpr double kSeriesReach = 0.5;
constexpr int kSeriesTerms = 18;
// Of a doubling each result is a sum of at most three products, of numbers of size 1 and slopes of size 1:
// errors grow to less than 8 times theirs, in the 7 doublings of a sensor of rate 64 to less than 2e-9.
constexpr double kFastestSensor = 64;
constexpr double kRounding = 1e-8;

Response Series(double time, const Rates& rates) noexcept {
  const auto& [a, kappa, l] = rates;
  Response response;
  Number before{};
  Number motion = kOne;
  Number sensed{l, 0, 0};
  Number lost{};
  Number lost_after{};
  double power = time;  // t^n / n!
  for (int n = 1; n <= kSeriesTerms; ++n) {
    const double longer = power * time / (n + 1);
    response.impulse = response.impulse + power * motion;
    response.step = response.step + longer * motion;
    response.lost = response.lost + power * lost;
    response.after_step = response.after_step + power * sensed;
    response.after_ramp = response.after_ramp + longer * sensed;
    const Number next = -(a * motion) - kappa * before;
    const Number lost_next = motion - a * lost_after;
    sensed = l * (next - sensed);
    before = motion;
    motion = next;
    lost = lost_after;
    lost_after = lost_next;
    power = longer;
  }
  response.held = kOne - kappa * response.step;
  response.slope = response.held - a * response.impulse;
  return response;
}

Response Doubled(const Response& half, double half_time, const Rates& rates) noexcept {
  const auto& [a, kappa, l] = rates;
  const Number kept{std::exp(-l * half_time), 0, 0};
  const double decay = std::exp(-a.value * half_time);
  const Number damping_kept{decay, -half_time * decay, 0};
  const Number turned = kappa * (half.impulse * half.impulse);
  return {.impulse = half.impulse * (half.held + half.slope),
          .step = half.step * (kOne + half.held) + half.impulse * half.impulse,
          .slope = half.slope * half.slope - turned,
          .held = half.held * half.held - turned,
          .lost = 2.0 * (half.step * half.impulse) + half.lost * (2.0 * damping_kept + a * kappa * half.lost),
          .after_step = half.after_step * (kept + half.slope) - kappa * half.after_ramp * half.impulse,
          .after_ramp = half.after_ramp * (kept + half.held) + half.impulse * half.after_step};
}

// `time` above 0; after_step and after_ramp as eta and gamma.
Response After(double time, double a, double kappa, double l) noexcept {
  const Rates rates{.damping = {a, 1, 0}, .stiffness = {kappa, 0, 1}, .sensor = l};
  const double fastest = std::max({a, std::sqrt(kappa), l});
  int doublings = 0;
  double part = time;
  while (part * fastest > kSeriesReach) {
    part /= 2;
    ++doublings;
  }
  Response response = Series(part, rates);
  for (int i = 0; i < doublings; ++i) {
    response = Doubled(response, part, rates);
    part *= 2;
  }
  const double sensed = 1 / -std::expm1(-l * time);
  response.after_step = sensed * response.after_step;
  response.after_ramp = sensed * response.after_ramp;
  return response;
}

// What a box knows of one plant's tick, up to a time.
struct Motion {
  Range impulse;
  Range step;
  Range slope;
  Range lost;
  Range eta;
  Range gamma;
};

// Both and all between; `spread` more for a slope.
Interval Hull(double x, double y, double spread) noexcept {
  const double slack = kRounding + spread;
  return {std::min(x, y) - slack, std::max(x, y) + slack};
}
Range Hull(const Number& x, const Number& y, double spread) noexcept {
  return {Hull(x.value, y.value, 0), Hull(x.by_damping, y.by_damping, spread),
          Hull(x.by_stiffness, y.by_stiffness, spread)};
}
Interval Hull(const Interval& x, const Interval& y) noexcept {
  return {std::min(x.lo, y.lo), std::max(x.hi, y.hi)};
}
Range Hull(const Range& x, const Range& y) noexcept {
  return {Hull(x.value, y.value), Hull(x.by_damping, y.by_damping), Hull(x.by_stiffness, y.by_stiffness)};
}
Motion Hull(const Motion& x, const Motion& y) noexcept {
  return {Hull(x.impulse, y.impulse), Hull(x.step, y.step), Hull(x.slope, y.slope),
          Hull(x.lost, y.lost),       Hull(x.eta, y.eta),   Hull(x.gamma, y.gamma)};
}

// Times so short that nothing differs from time 0 by more than the rounding.
constexpr double kShort = 1e-12;

// The plants between two corners of the box, at the times between those of `v`.
class Corners {
 public:
  Corners(double a_low, double kappa_low, double a_high, double kappa_high, double rate) noexcept
      : a_low_(a_low), kappa_low_(kappa_low), a_high_(a_high), kappa_high_(kappa_high), rate_(rate) {}

  Motion Over(const Interval& v) const noexcept {
    const double spread = v.width() / 2;
    const Motion begin = At(std::max(v.lo, kShort), spread);
    return v.lo == v.hi ? begin : Hull(begin, At(std::max(v.hi, kShort), spread));
  }

 private:
  Motion At(double time, double spread) const noexcept {
    const Response low = After(time, a_low_, kappa_low_, rate_);
    const bool point = a_low_ == a_high_ && kappa_low_ == kappa_high_;
    const Response high = point ? low : After(time, a_high_, kappa_high_, rate_);
    return {.impulse = Hull(low.impulse, high.impulse, spread),
            .step = Hull(low.step, high.step, spread),
            .slope = Hull(low.slope, high.slope, spread),
            .lost = Hull(low.lost, high.lost, spread),
            .eta = Hull(low.after_step, high.after_step, spread),
            .gamma = Hull(low.after_ramp, high.after_ramp, spread)};
  }

  double a_low_;
  double kappa_low_;
  double a_high_;
  double kappa_high_;
  double rate_;
};

Range Constant(const Interval& value) noexcept { return {value, {}, {}}; }

// 1/x for x above 0.
Range Inverse(const Range& x) noexcept {
  const Interval inverse = Exactly(1) / x.value;
  const Interval slope = -Square(inverse);
  return {inverse, slope * x.by_damping, slope * x.by_stiffness};
}

Range Decay(const Range& a, const Interval& time) noexcept {
  const Interval decay = Exp(-(a.value * time));
  return {decay, -(time * decay), {}};
}

// Whole tick, its late part p and the rest, and f(p)/f_a.
struct Tick {
  Motion whole;
  Motion late;
  Motion rest;
  Interval late_time = Exactly(1);
  Interval share = Exactly(1);
  bool delayed = false;
};

std::array<Range, 3> Rise(const Tick& tick, const Range& a, const Range& kappa) noexcept {
  const Range one = Constant(Exactly(1));
  const Motion& whole = tick.whole;
  const Range inverse = Inverse(whole.step * (one - whole.slope) + whole.impulse * whole.impulse);
  if (!tick.delayed) {
    const Range pull = whole.eta * (a * whole.lost * inverse + one - whole.step * inverse) -
                       whole.gamma * whole.impulse * inverse;
    return {kappa * pull, whole.eta * inverse, {}};
  }
  const auto& [impulse, step, slope, lost, eta, gamma] = tick.rest;
  const Range kept = Decay(a, tick.late_time);
  const Range sensed = Constant(tick.share) * tick.late.eta;
  const Range shares = kept * (impulse * impulse - slope * step) - tick.late.step;
  const Range pull = whole.eta * ((a * (tick.late.lost + kept * lost) + shares) * inverse) -
                     whole.gamma * (tick.late.impulse + kept * impulse) * inverse + sensed;
  const Range latest = whole.eta * tick.late.slope - kappa * whole.gamma * tick.late.impulse +
                       sensed * (one - Decay(a, Exactly(1)));
  return {kappa * pull, latest * inverse + kappa * sensed, sensed * inverse};
}

}  // namespace

std::optional<std::array<Interval, 3>> EncloseRiseBySlopes(const SensedPlants& plants,
                                                           const Interval& rate) noexcept {
  constexpr double kUnturned = 6;   // well below pi^2: h' is zero at most once in a tick
  constexpr double kMoving = 1e-6;  // so that rounding does not hide h'
  const Interval a = 2 * plants.alpha;
  const Interval& kappa = plants.kappa;
  const bool point = a.width() <= kRounding * a.hi && kappa.width() <= kRounding * kappa.hi;
  if (point || rate.hi >= kFastestSensor || kappa.hi > kUnturned || a.hi > 2 * kUnturned ||
      After(1, a.hi, kappa.hi, rate.hi).slope.value < kMoving) {
    return std::nullopt;
  }
  const double l = rate.middle();
  const double a_middle = a.middle();
  const double kappa_middle = kappa.middle();
  const Corners box(a.lo, kappa.lo, a.hi, kappa.hi, l);
  const Corners middle(a_middle, kappa_middle, a_middle, kappa_middle, l);
  Tick tick;
  tick.delayed = plants.fraction.hi > 0;
  const Interval& r = plants.fraction;
  if (tick.delayed) {
    const Interval left{Below(1 - r.hi), Above(1 - r.lo)};
    tick.late_time = {std::max(left.lo, 0.0), std::min(left.hi, 1.0)};
    const auto sensed = [&rate](double v) { return Exactly(v) * MeanDecay(rate * Exactly(v)); };
    const Interval all = MeanDecay(rate);
    tick.share = {std::max((sensed(tick.late_time.lo) / all).lo, 0.0),
                  std::min((sensed(tick.late_time.hi) / all).hi, 1.0)};
  }
  const auto rise = [&](const Corners& corners, const Range& damping, const Range& stiffness) {
    tick.whole = corners.Over(Exactly(1));
    if (tick.delayed) {
      tick.late = corners.Over(tick.late_time);
      tick.rest = corners.Over(r);
    }
    return Rise(tick, damping, stiffness);
  };
  const auto over_box = rise(box, {a, Exactly(1), {}}, {kappa, {}, Exactly(1)});
  const auto at_middle = rise(middle, Constant(Exactly(a_middle)), Constant(Exactly(kappa_middle)));
  std::array<Interval, 3> enclosed;
  for (std::size_t i = 0; i < enclosed.size(); ++i) {
    const Interval by_slopes = at_middle.at(i).value + over_box.at(i).by_damping * (a - Exactly(a_middle)) +
                               over_box.at(i).by_stiffness * (kappa - Exactly(kappa_middle));
    enclosed.at(i) = Meet(over_box.at(i).value, by_slopes);
  }
  return enclosed;
}

}  // namespace mwidth::model
