// The nearly constant factors of the sampled plant at one point, enclosed; plant_range.h says what they are.
#pragma once

#include "server/model/interval.h"

namespace mwidth::model {

/// Which bound a value is for. Where alpha and kappa are too near critical damping for the closed forms,
/// which divide 0 by 0 there, kappa is moved a little to that side: all functions here rise with it.
enum class BoundSide { kLower, kUpper };

/// X, Y and lead/alpha.
struct PlantFactors {
  Interval x;
  Interval y;
  Interval lead_rate;
};

/// At alpha and kappa, both at least 0, kappa - alpha^2 below pi^2. Any thread.
PlantFactors FactorsAt(double alpha, double kappa, BoundSide side) noexcept;

/// The motion e^(-a v) sin(w v)/w, or sinh, with w^2 of either sign and below pi^2.
struct TickMotion {
  double a = 0;
  double w_squared = 0;
};

/// The motion with the fast pole of one overdamped plant, alpha + sqrt(alpha^2 - kappa), and the slow pole of
/// another, rounded to the given side. psi rises with both poles, which depend less on each other than a and
/// w^2 do.
TickMotion WithPoles(double fast_alpha, double fast_kappa, double slow_alpha, double slow_kappa,
                     BoundSide side) noexcept;

/// psi(s) = J(s)/J(1), 0 to 1: how much of a tick's motion is done after the part s of it.
Interval ShareBefore(double s, const TickMotion& motion, BoundSide side) noexcept;

}  // namespace mwidth::model
