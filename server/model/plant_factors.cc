#include "server/model/plant_factors.h"

#include <algorithm>
#include <cmath>

namespace mwidth::model {
namespace {

// How far w^2 is kept from 0, relative to 1 + alpha^2: the least that moving it there adds to a bound, and
// the most that cancellation does.
constexpr double kCritical = 1e-8;
constexpr double kCriticalShare = 3e-7;

double AwayFromCritical(double w_squared, double alpha, BoundSide side, double distance) noexcept {
  const double least = distance * (1 + alpha * alpha);
  if (std::abs(w_squared) >= least) {
    return w_squared;
  }
  return side == BoundSide::kLower ? -2 * least : 2 * least;
}

// x/2 coth(x/2), 1 at 0.
Interval HalfCoth(const Interval& x) noexcept {
  const Interval decay = Exp(-x);
  return (1 + decay) / (2 * MeanDecay(x));
}

// No stiffness: kappa = 0.
PlantFactors FreeFactors(double alpha) noexcept {
  const Interval coth = HalfCoth(Exactly(2 * alpha));
  const double least = Below(Below(1.0 / 3) - Above(alpha * alpha / 45));  // from the series of lead
  Interval lead_rate{least, Above(1.0 / 3)};
  if (alpha > 0.1) {
    lead_rate = Meet(lead_rate, (coth - Exactly(1)) / Square(Exactly(alpha)));
  }
  return {.x = coth, .y = Exactly(1), .lead_rate = lead_rate};
}

// Real poles alpha -+ b, b > 0: `fast` and `slow` = kappa / fast.
PlantFactors OverdampedFactors(const Interval& alpha, const Interval& kappa, const Interval& b) noexcept {
  const Interval fast = alpha + b;
  const Interval slow = kappa / fast;
  const Interval fast_coth = HalfCoth(fast);
  const Interval slow_coth = HalfCoth(slow);
  return {.x = fast_coth * slow_coth + 0.25 * kappa,
          .y = (slow * fast_coth + fast * slow_coth) / (fast + slow),
          .lead_rate = (fast_coth - slow_coth) / (b * alpha)};
}

// q = e^-alpha kappa C2, G's denominator at z = 1.
Interval StaticGap(const Interval& decay, const Interval& alpha, const Interval& w) noexcept {
  return Square(alpha * MeanDecay(alpha)) + 4 * (decay * Square(Sin(0.5 * w)));
}

// Complex poles alpha -+ j w, w > 0.
PlantFactors OscillatingFactors(const Interval& alpha, const Interval& kappa, const Interval& w) noexcept {
  const Interval decay = Exp(-alpha);
  const Interval q = StaticGap(decay, alpha, w);
  const Interval mean_decay = MeanDecay(2 * alpha);
  return {.x = kappa * (1 + Square(decay)) / (2 * q),
          .y = kappa * mean_decay / q,
          .lead_rate = 2 * (mean_decay - decay * Sin(w) / w) / q};
}

// e^m times the integral over 0..s of e^(-y v) dv, which falls with y. y.lo >= m, m <= 0.
Interval ScaledDecay(const Interval& y, double s, double m) noexcept {
  const auto at = [s, m](double rate) {
    return s * MeanDecay(Exactly(std::abs(rate)) * Exactly(s)) *
           Exp(Exactly(m) + Exactly(std::max(-rate, 0.0)) * Exactly(s));
  };
  return {at(y.hi).lo, at(y.lo).hi};
}

// J(s), scaled by a power of e that depends on a and w^2 alone, so that nothing overflows.
Interval ScaledStep(double s, double a, double w_squared) noexcept {
  const Interval rate = Exactly(a);
  if (w_squared < 0) {
    const Interval b = Sqrt(Exactly(-w_squared));
    const Interval slow = rate - b;
    const double m = std::min(slow.lo, 0.0);
    return (ScaledDecay(slow, s, m) - ScaledDecay(rate + b, s, m)) / (2 * b);
  }
  const Interval w = Sqrt(Exactly(w_squared));
  const Interval m = Exactly(std::min(a, 0.0));
  const Interval turn = Cos(s * w) + rate * Sin(s * w) / w;
  return (Exp(m) - Exp(m - s * rate) * turn) / (Exactly(w_squared) + Square(rate));
}

}  // namespace

PlantFactors FactorsAt(double alpha, double kappa, BoundSide side) noexcept {
  const double w_squared = kappa - alpha * alpha;
  const double moved = AwayFromCritical(w_squared, alpha, side, kCritical);
  if (moved != w_squared) {
    kappa = alpha * alpha + moved;
  }
  if (kappa <= 0) {
    return FreeFactors(alpha);
  }
  const Interval a = Exactly(alpha);
  const Interval k = Exactly(kappa);
  return moved < 0 ? OverdampedFactors(a, k, Sqrt(Square(a) - k))
                   : OscillatingFactors(a, k, Sqrt(k - Square(a)));
}

TickMotion WithPoles(double fast_alpha, double fast_kappa, double slow_alpha, double slow_kappa,
                     BoundSide side) noexcept {
  const auto fast_pole = [](double alpha, double kappa) {
    const Interval a = Exactly(alpha);
    return a + Sqrt(Square(a) - Exactly(kappa));
  };
  const Interval fast = fast_pole(fast_alpha, fast_kappa);
  const Interval slow = Exactly(slow_kappa) / fast_pole(slow_alpha, slow_kappa);
  const Interval a = 0.5 * (fast + slow);
  const Interval w_squared = -Square(0.5 * (fast - slow));
  return side == BoundSide::kLower ? TickMotion{a.lo, w_squared.lo} : TickMotion{a.hi, w_squared.hi};
}

Interval ShareBefore(double s, const TickMotion& motion, BoundSide side) noexcept {
  if (s <= 0 || s >= 1) {
    return Exactly(s <= 0 ? 0 : 1);
  }
  const auto [a, w_squared] = motion;
  const double moved = AwayFromCritical(w_squared, a, side, kCriticalShare);
  const Interval whole = ScaledStep(1, a, moved);
  if (whole.lo <= 0) {
    return {0, 1};
  }
  const Interval ratio = ScaledStep(s, a, moved) / whole;
  return {std::clamp(ratio.lo, 0.0, 1.0), std::clamp(ratio.hi, 0.0, 1.0)};
}

}  // namespace mwidth::model
