// What the sampled plant can be while its parameters range over a box: bounds that leave nothing out.
//
// On the unit circle z = e^(jt), with u = 2 - 2 cos t and x = u/4, the equation of crossing.h divided by
// u (Phi + g), which is u q/kappa, reads
//
//   k T^2/u - mu X + j sin(t) beta T Y/u = M V        V = (-T^2 C(z)/u) (n0 + n1/z + n2/z^2) z^-delay_ticks
//
// with C(z) the estimator (eqs. 3, 4), n0 + n1 + n2 = 1 the shares of the latest forces and, where
// w^2 = kappa - alpha^2 and C2 = 2 (cosh(alpha) - cos(w)) / kappa,
//
//   X = cosh(alpha) / C2      Y = sinh(alpha) / (alpha C2)        both near 1 while little happens in a tick
//   lead = d ln(C2)/d alpha   n0 = (1 + lead)/2 psi(1 - r; alpha)   n2 = (1 - lead)/2 psi(r; -alpha)
//   psi(s; a) = J(s)/J(1)     J(s) = integral over 0..s of e^(-a v) sin(w v)/w dv    r: the delay's fraction
//
// k, mu, beta and M stand in it linearly, and everything else varies little: this is what makes bounds tight.
// While w^2 is below pi^2 (a natural frequency below half the sample rate, or none) the values at two corners
// bound each factor over a box:
//
//   X         rises with alpha and with kappa
//   Y         falls with alpha, rises with kappa
//   lead      rises with kappa, from coth(alpha) - 1/alpha; at most 1
//   lead/alpha  falls with alpha
//   psi       rises with s, with a and with w^2
//
// The README of this folder proves it. Beyond, interval arithmetic bounds them.
#pragma once

#include <array>
#include <limits>

#include "server/model/interval.h"

namespace mwidth::model {

/// A box of plants: every parameter anywhere in its range, independently.
struct PlantBox {
  /// mu = m + m_h, above 0.
  Interval mass;
  /// beta = b + b_h.
  Interval damping;
  /// k = k_h.
  Interval stiffness;
  /// Loop delay in ticks: delay_ticks + fraction, fraction in 0..1.
  int delay_ticks = 0;
  Interval fraction{};
  /// What else is known of alpha = beta T / (2 mu) and kappa = k T^2 / mu.
  Interval alpha{0, std::numeric_limits<double>::infinity()};
  Interval kappa{0, std::numeric_limits<double>::infinity()};
};

/// What is known of all plants of a box.
enum class PlantKnowledge {
  /// Nothing: the box must be divided.
  kUnbounded,
  /// No plant of the box has the alpha or kappa that is asked for.
  kNone,
  /// All of PlantRange.
  kBounded,
  /// PlantRange but X and Y, and counted from z = -1: the masses and k T^2/u are all less by k T^2/4. At the
  /// natural frequencies that alias to half the sample rate nothing is left of their difference, which would
  /// drown.
  kBoundedFromHalfRate,
};

/// Bounds for every plant of a box. All but the factors and shares have the unit of a mass.
struct PlantRange {
  PlantKnowledge knowledge = PlantKnowledge::kUnbounded;
  Interval alpha;
  Interval kappa;
  /// X and Y.
  Interval mass_factor;
  Interval damping_factor;
  /// mu X.
  Interval moving_mass;
  /// mu X - beta T Y/2 = mu e^-alpha / C2: what strong damping leaves of it.
  Interval damped_mass;
  /// beta T Y.
  Interval damping;
  /// k T^2; exactly 0 without stiffness.
  Interval stiffness;
  /// n0 and n2.
  Interval newest;
  Interval oldest;
  /// e0, e1 and e2 of acceleration_range.h; of accelerometers only.
  std::array<Interval, 3> rise{};
};

/// How the plant is sampled.
struct PlantSampling {
  /// T.
  double period_s = 0;
  /// w_a T of an accelerometer, above 0; 0 without one.
  Interval sensor_rate{};
};

/// Any thread.
PlantRange Enclose(const PlantBox& box, const PlantSampling& sampling) noexcept;

}  // namespace mwidth::model
