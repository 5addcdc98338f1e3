#include "server/model/acceleration_range.h"

#include <algorithm>
#include <cmath>

#include "server/model/acceleration_slopes.h"

namespace mwidth::model {
namespace {

// Below this product of time and rate each term of the series is less than 1/n of the one before.
constexpr double kSeriesReach = 0.5;
constexpr int kSeriesTerms = 18;
// What is left of each series, relative to its first term: coefficients grow like Fibonacci's numbers times
// powers of the fastest rate, so that it is below 3 (1.62/2)^18 / 19!.
constexpr Interval kRemainder{-1e-18, 1e-18};

// The motion of one plant, and what is sensed of it, after a time from rest: accelerometer_response.h, in
// interval arithmetic and with d, spring_loss over a kappa.
struct Response {
  Interval impulse{};
  Interval step{};
  Interval slope = Exactly(1);
  /// 1 - kappa Phi: what is left of a unit position.
  Interval held = Exactly(1);
  Interval lost{};
  Interval after_step{};
  Interval after_ramp{};
};

struct Rates {
  Interval damping;
  Interval stiffness;
  Interval sensor;
};

Response Series(double time, const Rates& rates) noexcept {
  const auto& [a, kappa, l] = rates;
  const Interval t = Exactly(time);
  Response response;
  Interval before{};
  Interval motion = Exactly(1);
  Interval sensed = l;
  Interval lost{};
  Interval lost_after{};
  Interval power = t;  // t^n / n!
  for (int n = 1; n <= kSeriesTerms; ++n) {
    const Interval longer = power * t / Exactly(n + 1);
    response.impulse = response.impulse + motion * power;
    response.step = response.step + motion * longer;
    response.lost = response.lost + lost * power;
    response.after_step = response.after_step + sensed * power;
    response.after_ramp = response.after_ramp + sensed * longer;
    const Interval next = -(a * motion) - kappa * before;
    const Interval lost_next = motion - a * lost_after;
    sensed = l * (next - sensed);
    before = motion;
    motion = next;
    lost = lost_after;
    lost_after = lost_next;
    power = longer;
  }
  response.impulse = response.impulse + kRemainder * t;
  response.step = response.step + kRemainder * Square(t);
  response.lost = response.lost + kRemainder * (t * Square(t));
  response.after_step = response.after_step + kRemainder * (l * t);
  response.after_ramp = response.after_ramp + kRemainder * (l * Square(t));
  response.held = 1 - kappa * response.step;
  response.slope = response.held - a * response.impulse;
  return response;
}

// After twice the time. Neither velocity nor position ever exceeds what it began with.
Response Doubled(const Response& half, double half_time, const Rates& rates) noexcept {
  const auto& [a, kappa, l] = rates;
  const Interval unit{-1, 1};
  const Interval kept = Exp(-(l * Exactly(half_time)));
  const Interval damping_kept = Exp(-(a * Exactly(half_time)));
  const Interval turned = kappa * Square(half.impulse);
  Response whole;
  whole.impulse = half.impulse * (half.held + half.slope);
  whole.step = half.step * (1 + half.held) + Square(half.impulse);
  whole.slope = Meet(Square(half.slope) - turned, unit);
  whole.held = Meet(Square(half.held) - turned, unit);
  whole.lost = 2 * (half.step * half.impulse) + half.lost * (2 * damping_kept + a * kappa * half.lost);
  whole.after_step = half.after_step * (kept + half.slope) - kappa * half.after_ramp * half.impulse;
  whole.after_ramp = half.after_ramp * (kept + half.held) + half.impulse * half.after_step;
  return whole;
}

// `time` above 0.
Response After(double time, const Rates& rates) noexcept {
  const double fastest = Above(std::max({rates.damping.hi, std::sqrt(rates.stiffness.hi), rates.sensor.hi}));
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
  return response;
}

double Radius(const Interval& a, double middle) noexcept {
  return Above(std::max(a.hi - middle, middle - a.lo));
}

// Everything that a value at the middle, and slopes no steeper than these, leave; and `possible`.
Interval Near(const Interval& middle, double reach, double possible) noexcept {
  return Meet({Below(middle.lo - reach), Above(middle.hi + reach)}, {-possible, possible});
}

// (1 - e^(-l v)) / (l v).
Interval MeanSensed(const Interval& rate, double v) noexcept { return MeanDecay(rate * Exactly(v)); }

// h', h, d, eta and gamma at a time 0 <= v <= 1, of all plants of a box.
struct SensedMotion {
  Interval slope{-1, 1};
  Interval impulse{};
  Interval lost{};
  Interval eta{-1, 1};
  Interval gamma{};
};

// Of the part of `motion` that is possible while no plant swings through its rest within a tick.
void MeetDamped(SensedMotion& motion, const Interval& v, const Interval& damping, const Interval& kappa,
                const Interval& rate) noexcept {
  constexpr double kUnswung = 6;  // of kappa, well below pi^2
  if (kappa.hi > kUnswung || v.lo <= 0) {
    return;
  }
  const Interval time = Exactly(v.hi);
  // h_1 at the end, and the largest step.
  const Interval most = time * MeanDecay(Exactly(damping.lo) * time);
  const double by_damping = damping.lo > 0 ? Above(v.hi / damping.lo) : 1;
  const double step = std::min(Above(v.hi * v.hi / 2), by_damping);
  const double spring = Above(kappa.hi * step);
  const Interval free = Exp(-(damping * v));
  motion.slope = Meet(motion.slope, {Below(free.lo - spring), Above(free.hi + spring)});
  const Interval least = Exactly(v.lo) * MeanDecay(Exactly(damping.hi) * Exactly(v.lo));
  motion.impulse = Meet(motion.impulse, {Below(least.lo - Above(most.hi * spring)), most.hi});
  motion.lost = Meet(motion.lost, {0, Above(most.hi * step)});
  motion.gamma = Meet(motion.gamma, {0, most.hi});
  // The mean of e^(-a s), which falls with a and with v.
  const auto mean = [&rate](double a, double end) {
    const Interval slower{std::min(a, rate.lo), std::min(a, rate.hi)};
    const Interval apart{std::max({0.0, Below(a - rate.hi), Below(rate.lo - a)}),
                         std::max(Above(a - rate.lo), Above(rate.hi - a))};
    const Interval t = Exactly(end);
    return Exp(-(slower * t)) * MeanDecay(apart * t) / MeanDecay(rate * t);
  };
  motion.eta = Meet(motion.eta,
                    {Below(mean(damping.hi, v.hi).lo - spring), Above(mean(damping.lo, v.lo).hi + spring)});
}

SensedMotion Enclose(const Interval& v, const Interval& damping, const Interval& kappa,
                     const Interval& rate) noexcept {
  SensedMotion motion;
  if (v.hi <= 0) {
    motion.slope = Exactly(1);
    return motion;
  }
  const double time = v.middle();
  const Rates middle{Exactly(damping.middle()), Exactly(kappa.middle()), rate};
  const double by_damping = Radius(damping, middle.damping.lo);
  const double by_kappa = Radius(kappa, middle.stiffness.lo);
  const double by_time = Radius(v, time);
  const double t = v.hi;
  const double t2 = t * t;
  // Roundings of these few products, all of terms above 0, are a share of them.
  const auto reach = [&](double damping_slope, double kappa_slope, double time_slope) {
    return Above(by_damping * damping_slope + by_kappa * kappa_slope + by_time * time_slope, 64);
  };
  const double slope_reach = reach(t, t2 / 2, damping.hi + kappa.hi * t);
  const double impulse_reach = reach(t2 / 2, t2 * t / 6, 1);
  const double lost_reach = reach(t2 * t2 / 12, t2 * t2 * t / 120, t2 / 2);
  const Response at = After(time, middle);
  const Interval sensed = rate * (Exactly(time) * MeanSensed(rate, time));
  motion.slope = Near(at.slope, slope_reach, 1);
  motion.impulse = Near(at.impulse, impulse_reach, t);
  motion.lost = Near(at.lost, lost_reach, Above(t2 * t / 6, 16));
  motion.eta = Near(at.after_step / sensed, slope_reach, 1);
  motion.gamma = Near(at.after_ramp / sensed, impulse_reach, t);
  MeetDamped(motion, v, damping, kappa, rate);
  return motion;
}

}  // namespace

std::array<Interval, 3> EncloseRise(const SensedPlants& plants, const Interval& rate) noexcept {
  if (const auto enclosed = EncloseRiseBySlopes(plants, rate)) {
    return *enclosed;
  }
  const auto& [alpha, kappa, fraction, inverse_gain, newest, oldest] = plants;
  const Interval a = 2 * alpha;
  const SensedMotion whole = Enclose(Exactly(1), a, kappa, rate);
  if (fraction.hi <= 0) {
    const Interval pull = whole.eta * (a * whole.lost * inverse_gain + (1 - newest)) -
                          whole.gamma * whole.impulse * inverse_gain;
    return {kappa * pull, whole.eta * inverse_gain, Exactly(0)};
  }
  const Interval left{Below(1 - fraction.hi), Above(1 - fraction.lo)};
  const Interval p{std::max(left.lo, 0.0), std::min(left.hi, 1.0)};
  const SensedMotion late = Enclose(p, a, kappa, rate);
  const SensedMotion rest = Enclose(fraction, a, kappa, rate);
  const Interval all = MeanSensed(rate, 1);
  const Interval share{std::max((Exactly(p.lo) * MeanSensed(rate, p.lo) / all).lo, 0.0),
                       std::min((Exactly(p.hi) * MeanSensed(rate, p.hi) / all).hi, 1.0)};
  const Interval sensed = late.eta * share;  // y_p
  const Interval kept = Exp(-(a * p));
  const Interval lost = late.lost + kept * rest.lost;
  const Interval impulse = late.impulse + kept * rest.impulse;
  const Interval pull =
      whole.eta * (a * lost * inverse_gain + oldest - newest) - whole.gamma * impulse * inverse_gain + sensed;
  const Interval latest =
      whole.eta * late.slope - kappa * whole.gamma * late.impulse + sensed * (a * MeanDecay(a));
  return {kappa * pull, latest * inverse_gain + kappa * sensed, sensed * inverse_gain};
}

}  // namespace mwidth::model
