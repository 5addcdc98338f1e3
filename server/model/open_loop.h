// The open loop of one virtual mass on the unit circle: its values, and its sizes as polynomials.
//
//   symbol   meaning
//   L        M C(z) G(z) z^-delay; 1 + L is the characteristic function
//   s, u     sin^2(t/2) at z = e^(jt); u = |z - 1|^2 = 4 s
//   A, B     of the estimator, C(z) = w^2 A(w) / B(w) with w = z - 1
//   N        numerator that the hold leaves, n0 + n1/z + n2/z^2 (other symbols: plant.h)
//
// On the circle w^2 = -u z, and G's denominator is z (rho + j delta sin t) with rho = q - u (1 - delta/2), so
//
//   L = top/bottom     top = -M (T^2/mu) u A N z^(1 - delay_ticks)     bottom = B (rho + j delta sin t)
//
// and nothing cancels near z = 1. With an accelerometer (accelerometer.h; A, B of the filter behind it)
//
//   top = M/mu A w N(w) z^(-1 - delay_ticks - [1])     bottom = (w + f_a) B (rho + j delta sin t)
//
// A free mass without friction has q = delta = 0; there u divides both and is
// left out.
#pragma once

#include <complex>
#include <vector>

#include "server/model/accelerometer.h"
#include "server/model/circle_arc.h"
#include "server/model/linear_estimator.h"
#include "server/model/plant.h"

namespace mwidth::model {

/// Numerator and denominator at one point.
struct OpenLoopValue {
  std::complex<double> top;
  std::complex<double> bottom;
};

/// Sizes along one arc.
struct OpenLoopOnArc {
  Arc arc;
  ArcForm top_squared;
  ArcForm bottom_squared;
  /// |top + bottom|^2.
  ArcForm sum_squared;
  /// OpenLoop::StepSize^2.
  ArcForm step_squared;
  /// Im L up to factors that have no zero inside the arc: L is real where this is 0.
  ArcForm imaginary;
};

/// The loop of one mass, plant and estimator. Immutable: any thread.
class OpenLoop {
 public:
  /// The degrees of A and B may sum to this.
  static constexpr int kMaxEstimatorDegree = kMaxRootDegree - 6;

  /// `mass` is M. Throws std::invalid_argument where the estimator's numerator lacks the factor w^2, or where
  /// it is of too high a degree.
  OpenLoop(const SampledPlant& plant, const LinearEstimator& estimator, double mass);
  /// With an accelerometer and AccelerometerFilter behind it; `moving_mass` is mu.
  OpenLoop(const SampledPlant& plant, const SampledAcceleration& acceleration, const LinearEstimator& filter,
           double moving_mass, double mass);

  /// At s = `half_sine_squared`, above 0, at most 1.
  OpenLoopValue At(double half_sine_squared) const;
  /// L itself, at s = 0 too: 0 there, but M/mu of a free mass without friction, where only masses resist.
  std::complex<double> Ratio(double half_sine_squared) const;
  /// |M C (1 - 1/z) (T^2/mu) bottom / (rho + j delta sin t)|: what a step of the force from tick to tick adds
  /// to top, at most, when the hold of it changes by 1. s = 0 too. From positions only, as
  /// OpenLoopOnArc::step_squared.
  double StepSize(double half_sine_squared) const;

  /// The sizes as polynomials, on arcs that together are the upper half of the circle. Around a resonance of
  /// small damping they become short, so that on none of them rho changes by more than a factor of 8 unless
  /// damping hides it.
  std::vector<OpenLoopOnArc> Arcs() const;

 private:
  bool IsFree() const { return plant_.static_gap == 0 && plant_.loss == 0; }
  std::vector<Arc> Divide() const;
  OpenLoopOnArc Expand(const Arc& arc) const;
  ArcForm HoldSquared(const Arc& arc) const;
  ComplexArcForm HeldAndDelayed(const Arc& arc) const;

  /// With an accelerometer a hold of 1, whose numerator is in a_, and all powers of 1/z as ticks of delay.
  SampledPlant plant_;
  bool senses_acceleration_ = false;
  DifferencePolynomial a_;
  DifferencePolynomial b_;
  /// M T^2/mu; M/mu with an accelerometer.
  double gain_;
};

}  // namespace mwidth::model
