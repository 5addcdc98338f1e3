#include "server/model/crossing_guess.h"

#include <algorithm>
#include <limits>

namespace mwidth::model {

std::optional<LoopParameters> GuessWorstPlant(double x, const PlantBox& box, const PlantRange& plant,
                                              const EstimatorRange& estimator, MassSign sign,
                                              double period_s) noexcept {
  const double mass_factor = plant.moving_mass.middle() / box.mass.middle();
  const double damping_factor = box.damping.hi > 0 ? plant.damping.middle() / box.damping.middle() : 0;
  PlantRange linear = plant;
  linear.moving_mass = mass_factor * box.mass;
  linear.damping = damping_factor * box.damping;
  linear.damped_mass = {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  linear.newest = Exactly(plant.newest.middle());
  linear.oldest = Exactly(plant.oldest.middle());
  for (Interval& rise : linear.rise) {
    rise = Exactly(rise.middle());
  }
  const Arc point(Exactly(x));
  const LoopRange factor = LoopFactor(estimator, point, linear, box.delay_ticks);
  const CrossingSizes sizes = BoundCrossings(point, linear, factor, sign);
  if (sizes.none()) {
    return std::nullopt;
  }
  const double m = sign == MassSign::kPositive ? sizes.lo : -sizes.lo;
  const bool from_half_rate = plant.knowledge == PlantKnowledge::kBoundedFromHalfRate;
  const double spring = period_s * period_s * (1 / (4 * x) - (from_half_rate ? 0.25 : 0));
  // On the diagonal from the heaviest and softest to the lightest and stiffest plant the elastic side rises.
  const double low = box.stiffness.lo * spring - box.mass.hi * mass_factor;
  const double high = box.stiffness.hi * spring - box.mass.lo * mass_factor;
  const double way = high > low ? std::clamp((m * factor.re.middle() - low) / (high - low), 0.0, 1.0) : 0;
  const double damping = damping_factor > 0 ? m * factor.u_im.middle() / damping_factor : 0;
  return LoopParameters{
      .device_mass = std::clamp(box.mass.hi - way * box.mass.width(), box.mass.lo, box.mass.hi),
      .device_damping = std::clamp(damping, box.damping.lo, box.damping.hi),
      .hand_stiffness =
          std::clamp(box.stiffness.lo + way * box.stiffness.width(), box.stiffness.lo, box.stiffness.hi),
      .delay_s = (box.delay_ticks + box.fraction.middle()) * period_s};
}

}  // namespace mwidth::model
