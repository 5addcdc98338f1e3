#include "server/model/crossing_range.h"

#include <algorithm>

namespace mwidth::model {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Keeps of `sizes` the m with m f = v for an f in `factor` and a v in `value`, which may be infinite on
// either side: those with m factor.lo <= value.hi and m factor.hi >= value.lo.
void KeepSolutions(CrossingSizes& sizes, const Interval& value, const Interval& factor) noexcept {
  const auto at_most = [&sizes](double f, double v) {  // m f <= v
    if (f > 0) {
      sizes.hi = std::min(sizes.hi, Above(v / f));
    } else if (f < 0) {
      sizes.lo = std::max(sizes.lo, Below(v / f));
    } else if (v < 0) {
      sizes.hi = -kInfinity;
    }
  };
  at_most(factor.lo, value.hi);
  at_most(-factor.hi, -value.lo);
}

Interval Signed(const Interval& a, MassSign sign) noexcept { return sign == MassSign::kPositive ? a : -a; }

bool IsZero(const Interval& a) noexcept { return a.lo == 0 && a.hi == 0; }

// z^-ticks = cos(n t) - j sin(n t), multiples of the angle as polynomials of its cosine.
CircleRange Delayed(const CircleRange& factor, const Arc& arc, int ticks) noexcept {
  const Interval& y = arc.cosine;
  switch (ticks) {
    case 0:
      return factor;
    case 1:
      return Multiply(factor, {y, Exactly(-1)}, arc);
    case 2:
      return Multiply(factor, {2 * Square(y) - Exactly(1), -2 * y}, arc);
    default:
      return Multiply(factor, {y * (4 * Square(y) - Exactly(3)), 1 - 4 * Square(y)}, arc);
  }
}

// With an accelerometer: e0/w + e1 + e2 w, where 1/w = -1/2 - j sin(t)/u.
LoopRange SensedFactor(const EstimatorRange& estimator, const Arc& arc, const PlantRange& plant,
                       int delay_ticks) noexcept {
  const auto& [pull, latest, newest] = plant.rise;
  CircleRange factor = Delayed(estimator.Over(arc), arc, delay_ticks);
  if (!IsZero(newest)) {
    factor = Delayed(factor, arc, 1);
  }
  const Interval u = 4 * arc.x;
  const Interval re = latest - 0.5 * pull - 2 * (arc.x * newest);
  const Interval u_im = u * newest - pull;
  // sin^2(t) = u (1 - x)
  return {factor.re * re - (1 - arc.x) * (factor.im * u_im), factor.re * u_im + u * (factor.im * re)};
}

}  // namespace

LoopRange LoopFactor(const EstimatorRange& estimator, const Arc& arc, const PlantRange& plant,
                     int delay_ticks) noexcept {
  if (!IsZero(estimator.sensor_rate())) {
    return SensedFactor(estimator, arc, plant, delay_ticks);
  }
  // n0 + n1/z + n2/z^2 = 1 - (1 - 1/z) (1 - n0 + n2/z)
  const Interval older = 1 - plant.newest;
  CircleRange shares{older, older};
  if (!IsZero(plant.oldest)) {
    shares.re = older + plant.oldest * (3 - 4 * arc.x);
    shares.im = older + plant.oldest * (1 - 4 * arc.x);
  }
  shares = {1 - 2 * (arc.x * shares.re), -shares.im};
  const CircleRange factor = Delayed(Multiply(estimator.Over(arc), shares, arc), arc, delay_ticks);
  return {factor.re, 4 * (arc.x * factor.im)};
}

CrossingSizes BoundCrossings(const Arc& arc, const PlantRange& plant, const LoopRange& factor,
                             MassSign sign) noexcept {
  CrossingSizes sizes;
  if (plant.knowledge == PlantKnowledge::kNone) {
    return {.lo = kInfinity, .hi = 0};
  }
  if (plant.knowledge == PlantKnowledge::kUnbounded) {
    return sizes;
  }
  const Interval u = 4 * arc.x;
  // At standstill stiffness and damping resist without limit, unless there are none.
  const auto over_u = [&u](const Interval& a) {
    return Interval{Below(a.lo / u.hi), a.hi <= 0 ? 0 : u.lo <= 0 ? kInfinity : Above(a.hi / u.lo)};
  };
  const auto minus = [](const Interval& a, const Interval& b) {
    return Interval{Below(a.lo - b.hi), Above(a.hi - b.lo)};
  };
  const bool from_half_rate = plant.knowledge == PlantKnowledge::kBoundedFromHalfRate;
  const Interval spring = over_u(from_half_rate ? plant.stiffness * (1 - arc.x) : plant.stiffness);
  KeepSolutions(sizes, minus(spring, plant.moving_mass), Signed(factor.re, sign));
  if (arc.real()) {
    return sizes;
  }
  KeepSolutions(sizes, plant.damping, Signed(factor.u_im, sign));
  KeepSolutions(sizes, minus(spring, plant.damped_mass), Signed(factor.re + 0.5 * factor.u_im, sign));
  return sizes;
}

bool Narrow(PlantBox& box, const Arc& arc, const PlantRange& plant, const LoopRange& factor, MassSign sign,
            const CrossingSizes& sizes) noexcept {
  // Below this alpha and kappa change X, Y and V little anyway, but for what an accelerometer sees.
  constexpr double kTame = 0.02;
  constexpr double kGoodPart = 0.7;
  if (plant.knowledge != PlantKnowledge::kBounded || arc.real() ||
      (IsZero(plant.rise[1]) && plant.alpha.hi < kTame && plant.kappa.hi < kTame)) {
    return false;
  }
  // Both equations divided by mu: kappa = u (X +- (m/mu) R), 2 alpha = u (+-(m/mu) I) / Y.
  const Interval u = 4 * arc.x;
  const Interval ratio = Signed({Below(sizes.lo / box.mass.hi), Above(sizes.hi / box.mass.lo)}, sign);
  const Interval kappa = Meet(plant.kappa, u * (plant.mass_factor + ratio * factor.re));
  const Interval alpha = Meet(plant.alpha, ratio * factor.u_im / (2 * plant.damping_factor));
  if (kappa.width() > kGoodPart * plant.kappa.width() && alpha.width() > kGoodPart * plant.alpha.width()) {
    return false;
  }
  box.alpha = alpha;
  box.kappa = kappa;
  return true;
}

}  // namespace mwidth::model
