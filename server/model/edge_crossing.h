// The two crossings that end the M-width: nearest to zero on either side.
//
// A rising mass, and a falling one, first meets the crossing nearest to 0 on its side. There is one on each:
// behind a hold the loop's numerator is below its denominator by one degree or more, whatever the estimator,
// so a large enough mass of either sign drives a root to infinity. An accelerometer that tells nothing,
// because damping leaves nothing to tell within a tick, has infinite edges.
//
// The paper's loop, without delay, has them in closed form. With the hold n0, n1 and the filter's pole a = 1
// - f (symbols: plant.h), the equations of crossing.h are
//
//   q - u (1 - delta/2) = M' X      delta = M' (n1 u - P)      M' = (M/mu) f u / (f^2 + a u)
//
//   P = n0 + n1 + f n1      h = n1 + a n0      e = n1 (q + delta)
//
// and without M' they are n1 u^2 - (P + e) u + Z = 0, Z = q P + delta f (n0 + n1). Its discriminant is a sum
// of two terms that are not negative,
//
//   (P + e)^2 - 4 n1 Z = (P - e)^2 + 4 n1 delta h
//
// so both roots are real. Let r be the larger root of r^2 - (P - e) r = n1 delta h and S = r + e. Then u_1 =
// Z/S and u_2 = S/n1, at the second equation P - n1 u_1 = r and n1 u_2 - P = n1 delta h / r, and
//
//   M_1 = -mu delta (f^2 S + a Z) / (f Z r)         M_2 = mu r (f^2 n1 + a S) / (f n1 h S)
//
// with no difference left but P - e. u_1 < q + delta < 4, and M_1 is the only negative crossing. M_2 is one
// where u_2 < 4. Then it is nearer than the crossing at z = -1: for a large M one root is outside, the real
// one that went to minus infinity, so that of the pair which left at M_2 the other one has to come back
// through z = -1. Without u_2 the one at z = -1 is the only positive one.
#pragma once

#include "server/model/crossing.h"
#include "server/model/estimator_factors.h"
#include "server/model/plant.h"

namespace mwidth::model {

/// The crossing of the greatest negative and the one of the least positive mass.
struct EdgeCrossings {
  Crossing lower;
  Crossing upper;
};

/// Those of all crossings; of infinite mass where there is none on a side. Any thread. Rt.
EdgeCrossings NearestToZero(const Crossings& crossings) noexcept;

/// The edges of the loop of `plant` and `estimator`; `moving_mass` is mu. Precondition: plant.loss > 0 or
/// plant.static_gap == 0. Any thread. Rt.
EdgeCrossings FindEdgeCrossings(const SampledPlant& plant, const EstimatorFactors& estimator,
                                double moving_mass) noexcept;

}  // namespace mwidth::model
