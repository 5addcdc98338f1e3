// The answer of the stability model about one mass, and the ranges behind it.
#pragma once

#include <optional>
#include <string>

#include "server/model/loop_parameters.h"
#include "server/model/margins.h"

namespace mwidth::gate {

/// An open, connected range of virtual masses around zero, or the reason why there is none.
struct Interval {
  double min = 0;
  double max = 0;
  /// One sentence where the interval is empty; then the edges are 0.
  std::string empty_reason;

  bool empty() const { return !empty_reason.empty(); }
  /// True when `mass` is strictly inside; false for NaN.
  bool Contains(double mass) const { return !empty() && min < mass && mass < max; }
};

/// Which masses a loop renders, from what the equations say to what is accepted.
struct MassRange {
  /// The loop exactly as its parameters say.
  Interval nominal;
  /// Every loop that the axis's assumptions allow.
  Interval robust;
  /// The robust interval shrunk by the required gain margin.
  Interval admitted;
  /// Frequency at which the loop oscillates at the lower and upper nominal edge; 0 where the interval is
  /// empty.
  double min_critical_hz = 0;
  double max_critical_hz = 0;
  double required_gain_margin_db = 0;
  /// The loops with the nearest edges among those that the robust interval holds for; the loop itself where
  /// there is no other. Not set where the interval is empty.
  std::optional<model::LoopParameters> min_binding;
  std::optional<model::LoopParameters> max_binding;
};

/// Why a mass is admitted or not.
struct StabilityReport {
  bool admitted = false;
  /// True for a mass inside the admitted interval that is refused all the same, for its force noise.
  bool noisy = false;
  double requested_mass = 0;
  MassRange range;
  model::LoopParameters loop;
  /// Factor by which the mass may grow before the nominal loop is unstable, in decibels: negative where it is
  /// unstable already, infinite for a mass of zero, minus infinite where the M-width is empty.
  double gain_margin_db = 0;
  /// Frequency at which the loop that binds oscillates at its edge on this mass's side; 0 where the robust
  /// interval is empty.
  double critical_hz = 0;
  /// Gain: what every assumed loop keeps, proved: the robust edge over the mass. The others: the least of
  /// each among the nominal loop and the two that bind the robust interval, which is no proof for the loops
  /// between.
  model::Margins margins;
  /// Standard deviation of the force that the encoder's counts cause; none where the mass is unstable, or
  /// where the axis does not limit it.
  std::optional<double> force_noise;
  /// What sets that edge, or the noise of a noisy mass: a sentence.
  std::string binding;
  /// The mass nearest to the requested one that is admitted and within the axis's hard limits; asking for
  /// exactly this mass is granted.
  double nearest_admitted_mass = 0;
  /// Where the mass is refused: a cut-off below the present one that would admit it, if any: the highest
  /// where one loop is assumed, near it where several are.
  std::optional<double> admitting_cutoff_hz;
};

}  // namespace mwidth::gate
