// Where the roots of a rendering loop meet the unit circle, and at which virtual masses.
//
// On the circle z = e^(jt), with w = z - 1 and u = |w|^2 = 2 - 2 cos t, (z-1)^2 = -u z, and the
// characteristic equation 1 + M C G z^-delay = 0 for the estimator C(z) = w^2 A/(T^2 B) reads
//
//   (q - u) z + delta w = (M/mu) u N(z) A z^(1 - delay_ticks) z / B        N = hold polynomial in 1/z
//
// (symbols: plant.h). The left side is the plant's denominator, free of cancellation. Let W = N A conj(B)
// z^(1 - delay_ticks) = X + j sin(t) Y; both X and Y are polynomials in u. Multiplied by conj(z), the two
// real equations of one complex one are
//
//   q - u (1 - delta/2) = M' X      delta = M' Y        M' = (M/mu) u / |B|^2
//
// so that M follows from either, and they agree where (q - u (1 - delta/2)) Y - delta X = 0: a polynomial in
// u. A and B are products (estimator_factors.h): A of a gain, of powers of z, and of (z + 1)^2 = 4 c z; B of
// factors of degree 1 and 2. Each turn of z joins a conj(B), so the degree stays low: 2 for the paper's
// estimator (A = f, B = z (w + f)), whose edges edge_crossing.h has in closed form, and one more for each
// tick, whole or begun, of delay; 3 for Butterworth and Kalman. The roots in (0, 4) and the point z = -1,
// where sin(t) = 0 and one equation is enough, are all crossings there are; zeros of A at z = -1 put that one
// at an infinite mass. Nothing is deflated numerically: a released hand has q = 0, a free mass without
// friction also delta = 0, and the equations stay as they are.
//
// An accelerometer (accelerometer.h) takes the same way, but has one zero at z = 1 only. Multiplied by
// conj(w), as w conj(w) = u and z conj(w) = -w,
//
//   (q - u) w - delta u = M' W      W = N(w) A conj(B) z^p      M' = (M/mu) u / |B|^2
//
// with p as above, one less without the digital filter. Left and right are u L and M' W there, L and M' W for
// the others: one form in cos^2(t/2) and sin^2(t/2), and the same condition, that the two are parallel.
#pragma once

#include <array>

#include "server/model/accelerometer.h"
#include "server/model/estimator_factors.h"
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

/// All crossings of the loop of `plant` and `estimator`; `moving_mass` is mu. Precondition: plant.loss > 0 or
/// plant.static_gap == 0. Any thread. Rt.
Crossings FindCrossings(const SampledPlant& plant, const EstimatorFactors& estimator,
                        double moving_mass) noexcept;

/// The same for an accelerometer and the AccelerometerFactors behind it.
Crossings FindCrossings(const SampledPlant& plant, const SampledAcceleration& acceleration,
                        const EstimatorFactors& factors, double moving_mass) noexcept;

}  // namespace mwidth::model
