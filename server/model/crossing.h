// Where the roots of a rendering loop meet the unit circle, and at which virtual masses.
//
// On the circle z = e^(jt), with w = z - 1 and u = |w|^2 = 2 - 2 cos t, (z-1)^2 = -u z, and the
// characteristic equation 1 + M H D G z^-delay = 0 reads
//
//   (q - u) z + delta w = M (f/mu) u N(z) / E(z)        E = (w + f) z^(1 + delay_ticks), N = hold polynomial
//
// with f = 1 - a, the filter's pole seen from z = 1 (other symbols: plant.h). The left side is the plant's
// denominator, free of cancellation. Let W = N conj(E) conj(z) = A + j sin(t) Y; both A and Y are polynomials
// in u. Multiplied by conj(z), the two real equations of one complex one are
//
//   q - u (1 - delta/2) = M' A      delta = M' Y        M' = M (f/mu) u / |w + f|^2
//
// so that M follows from either, and they agree where (q - u (1 - delta/2)) Y - delta A = 0: a polynomial in
// u, of degree 2 for the paper's loop and one more for each tick, whole or begun, of delay. Its roots in (0,
// 4) and the point z = -1, where sin(t) = 0 and one equation is enough, are all crossings there are. Nothing
// is deflated numerically: a released hand has q = 0, a free mass without friction also delta = 0, and the
// equations stay as they are.
#pragma once

#include <array>

#include "server/model/plant.h"
#include "server/model/real_roots.h"

namespace mwidth::model {

/// A virtual mass that puts a closed-loop root on the unit circle, at z = e^(jt).
struct Crossing {
  double mass = 0;
  /// sin^2(t/2): 0 at standstill, 1 at half the sample rate.
  double half_sine_squared = 0;
};

/// All crossings of one loop, in no order.
struct Crossings {
  std::array<Crossing, kMaxRootDegree + 1> found;
  int count = 0;

  const Crossing* begin() const { return found.data(); }
  const Crossing* end() const { return found.data() + count; }
};

/// All crossings of the loop of `plant`, first-order filter and double difference (eqs. 3 to 5). `filter_gap`
/// is f = 1 - a, above 0; `moving_mass` is mu. Precondition: plant.loss > 0 or plant.static_gap == 0. Any
/// thread. Rt.
Crossings FindCrossings(const SampledPlant& plant, double filter_gap, double moving_mass) noexcept;

}  // namespace mwidth::model
