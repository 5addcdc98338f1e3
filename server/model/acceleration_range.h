// What an accelerometer's numerator can be while the plant's parameters range over a box.
//
// With symbols of plant.h and accelerometer.h, a = 2 alpha, S = Phi + Gamma = q/kappa and f(v) = 1 - e^(-l v)
// for a sensor of rate l per tick, divided by u S the equation of crossing.h becomes that of plant_range.h
// with
//
//   V = H(z) f_a/(w + f_a) (e0/w + e1 + e2 w) z^(-delay_ticks - [1])        e = N's coefficients / (f_a S)
//
//   e0 = kappa (eta (a d(1) / S + 1 - n0) - gamma h(1) / S)    e1 = eta / S    e2 = 0    without a fraction
//
// and with a fraction r of a tick of delay, where p = 1 - r and y_p = eta(p) f(p) / f_a,
//
//   e0 = kappa (eta (a (d(p) + e^(-a p) d(r)) / S + n2 - n0) - gamma (h(p) + e^(-a p) h(r)) / S + y_p)
//   e1 = (eta h'(p) - kappa gamma h(p) + y_p (1 - e^-a)) / S + kappa y_p             e2 = y_p / S
//
// Here eta(v) = y(v)/f(v) and gamma(v) = g(v)/f(v) are means of h' and of h over 0..v, weighted towards the
// end, and d = h_1 * h with h_1 the impulse response without the spring. All of them vary little with little
// happening in a tick, and are bounded by their value at the middle of the box and their slopes: because
// |h'| <= 1 and |h| <= v,
//
//            by a      by kappa    by v
//   h'       v         v^2/2       a + kappa v
//   h        v^2/2     v^3/6       1
//   d        v^4/12    v^5/120     v^2/2
//
// at most, for eta and gamma as for h' and h. Strong damping leaves far less: while no plant swings through
// its rest within a tick, 0 <= h <= h_1 and h' = e^(-a v) + kappa (a d - Phi), so that with a Phi of at most
// v^2/2 and v/a every h' is within kappa Phi of e^(-a v), eta of its mean, and d <= h_1 Phi.
#pragma once

#include <array>

#include "server/model/interval.h"

namespace mwidth::model {

/// What is known of all plants of a box: alpha, kappa, the fraction of a tick of delay, 1/S and the shares n0
/// and n2 of plant_range.h.
struct SensedPlants {
  Interval alpha;
  Interval kappa;
  Interval fraction;
  Interval inverse_gain;
  Interval newest;
  Interval oldest;
};

/// e0, e1 and e2 for all of them, with the sensor's rate l per tick, above 0, in `rate`. e2 is exactly 0
/// where the fraction is. Any thread.
std::array<Interval, 3> EncloseRise(const SensedPlants& plants, const Interval& rate) noexcept;

}  // namespace mwidth::model
