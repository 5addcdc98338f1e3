#include "server/model/plant_range.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/model/acceleration_range.h"
#include "server/model/plant_factors.h"

namespace mwidth::model {
namespace {

// Up to this w^2, well below pi^2, monotony bounds; from 1 on interval arithmetic does. A box that is neither
// below the one nor above the other is divided.
constexpr double kUnaliased = 6;
constexpr double kOscillating = 1;

// alpha and kappa of a box, and the fraction of a tick.
struct Tick {
  Interval alpha;
  Interval kappa;
  Interval fraction;
};

Interval Lead(const Tick& tick, const Interval& rate) noexcept {
  const auto& [alpha, kappa, fraction] = tick;
  const double free_rate = FactorsAt(alpha.lo, 0, BoundSide::kLower).lead_rate.lo;
  double most = rate.hi;
  // Each term of the series of lead/alpha has a factor 1 - kappa/A, A >= 4 pi^2, squared in its denominator.
  const double distance = 1 - kappa.hi / (4 * std::numbers::pi * std::numbers::pi);
  if (distance > 0.5) {
    most = std::min(most, Above(1 / (3 * distance * distance), 16));
  }
  return {std::clamp(Below(alpha.lo * std::max(free_rate, rate.lo)), 0.0, 1.0),
          std::clamp(Above(alpha.hi * most), 0.0, 1.0)};
}

void EncloseShares(PlantRange& range, const Tick& tick, const Interval& lead) noexcept {
  const auto& [alpha, kappa, r] = tick;
  range.newest = 0.5 * (1 + lead);
  range.oldest = Exactly(0);
  if (r.hi <= 0) {
    return;
  }
  const double lo = Below(kappa.lo - Above(alpha.hi * alpha.hi));
  const double hi = Above(kappa.hi - Below(alpha.lo * alpha.lo));
  TickMotion latest{alpha.lo, lo};
  TickMotion earliest{alpha.hi, hi};
  if (hi < 0) {
    latest = WithPoles(alpha.lo, kappa.hi, alpha.hi, kappa.lo, BoundSide::kLower);
    earliest = WithPoles(alpha.hi, kappa.lo, alpha.lo, kappa.hi, BoundSide::kUpper);
  }
  range.newest = range.newest * Interval{ShareBefore(Below(1 - r.hi), latest, BoundSide::kLower).lo,
                                         ShareBefore(Above(1 - r.lo), earliest, BoundSide::kUpper).hi};
  range.oldest = 0.5 * (1 - lead) *
                 Interval{ShareBefore(r.lo, {-alpha.hi, lo}, BoundSide::kLower).lo,
                          ShareBefore(r.hi, {-alpha.lo, hi}, BoundSide::kUpper).hi};
}

// Returns 1/S.
Interval EncloseUnaliased(PlantRange& range, const PlantBox& box, const Tick& tick,
                          double period_s) noexcept {
  const auto& [alpha, kappa, fraction] = tick;
  const PlantFactors late = FactorsAt(alpha.hi, kappa.lo, BoundSide::kLower);
  const PlantFactors early = FactorsAt(alpha.lo, kappa.hi, BoundSide::kUpper);
  range.knowledge = PlantKnowledge::kBounded;
  range.mass_factor = {FactorsAt(alpha.lo, kappa.lo, BoundSide::kLower).x.lo,
                       FactorsAt(alpha.hi, kappa.hi, BoundSide::kUpper).x.hi};
  range.damping_factor = {late.y.lo, early.y.hi};
  range.moving_mass = box.mass * range.mass_factor;
  range.damping = box.damping * (period_s * range.damping_factor);
  // X e^-alpha / cosh(alpha) = e^-alpha / C2 falls with alpha and rises with kappa, as 1 / C2 does.
  const auto damped = [](const Interval& x, double at) {
    const Interval decay = Exp(-2 * Exactly(at));
    return 2 * (x * decay) / (1 + decay);
  };
  range.damped_mass = box.mass * Interval{damped(late.x, alpha.hi).lo, damped(early.x, alpha.lo).hi};
  EncloseShares(range, tick, Lead(tick, {late.lead_rate.lo, early.lead_rate.hi}));
  return 2 * range.mass_factor / (1 + Exp(-2 * alpha));  // X e^alpha / cosh(alpha)
}

// The natural frequency may be above half the sample rate: interval arithmetic in alpha and w. q is G's
// denominator at z = 1, which e^-alpha kappa C2 is, `half_rate_gap` likewise at z = -1. Returns 1/S.
Interval EncloseAliased(PlantRange& range, const Tick& tick) noexcept {
  const auto& [alpha, kappa, r] = tick;
  const Interval w_squared = kappa - Square(alpha);
  if (w_squared.lo < kOscillating) {
    return {};
  }
  const Interval w = Sqrt(w_squared);
  const Interval decay = Exp(-alpha);
  const Interval own_loss = Square(alpha * MeanDecay(alpha));  // (1 - e^-alpha)^2
  const Interval q = own_loss + 4 * (decay * Square(Sin(0.5 * w)));
  if (q.lo <= 0) {
    return {};
  }
  const Interval half_rate_gap = own_loss + 4 * (decay * Square(Cos(0.5 * w)));
  range.knowledge = PlantKnowledge::kBoundedFromHalfRate;
  range.moving_mass = range.stiffness * half_rate_gap / (4 * q);
  range.damped_mass = range.stiffness * (Square(decay) / q - Exactly(0.25));
  range.damping = range.stiffness * (2 * alpha * MeanDecay(2 * alpha)) / q;
  if (r.hi <= 0) {
    range.newest = 0.5 * (1 + 2 * alpha * (MeanDecay(2 * alpha) - decay * Sin(w) / w) / q);
    range.oldest = Exactly(0);
    return kappa / q;
  }
  const Interval rest = 1 - r;
  const Interval slope = alpha / w;
  range.newest = (1 - Exp(-(alpha * rest)) * (Cos(w * rest) + slope * Sin(w * rest))) / q;
  range.oldest = (Square(decay) - Exp(-(alpha * (1 + rest))) * (Cos(w * r) - slope * Sin(w * r))) / q;
  return kappa / q;
}

}  // namespace

PlantRange Enclose(const PlantBox& box, const PlantSampling& sampling) noexcept {
  const auto not_negative = [](const Interval& x) { return Interval{std::max(x.lo, 0.0), x.hi}; };
  const Interval period = Exactly(sampling.period_s);
  PlantRange range;
  range.stiffness = box.stiffness.hi > 0 ? not_negative(box.stiffness * Square(period)) : Exactly(0);
  range.alpha = Meet(not_negative(0.5 * (box.damping * period / box.mass)), box.alpha);
  range.kappa = Meet(not_negative(range.stiffness / box.mass), box.kappa);
  if (range.alpha.lo > range.alpha.hi || range.kappa.lo > range.kappa.hi) {
    range.knowledge = PlantKnowledge::kNone;
    return range;
  }
  const Tick tick{.alpha = range.alpha, .kappa = range.kappa, .fraction = box.fraction};
  const bool unaliased = range.kappa.hi - range.alpha.lo * range.alpha.lo <= kUnaliased;
  const Interval inverse_gain =
      unaliased ? EncloseUnaliased(range, box, tick, sampling.period_s) : EncloseAliased(range, tick);
  if (sampling.sensor_rate.hi > 0 && range.knowledge != PlantKnowledge::kUnbounded) {
    range.rise = EncloseRise({.alpha = range.alpha,
                              .kappa = range.kappa,
                              .fraction = box.fraction,
                              .inverse_gain = inverse_gain,
                              .newest = range.newest,
                              .oldest = range.oldest},
                             sampling.sensor_rate);
  }
  return range;
}

}  // namespace mwidth::model
