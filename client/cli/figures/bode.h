// Bode plots of loops.
#pragma once

#include <complex>
#include <functional>
#include <string>
#include <vector>

#include "client/cli/figures/paper_loops.h"
#include "client/cli/plot/chart.h"
#include "server/model/m_width.h"

namespace mwidth::figures {

/// One loop of a Bode plot.
struct BodeLoop {
  std::string name;
  /// L at a frequency in Hz.
  std::function<std::complex<double>(double)> gain;
  /// The mass M of L, and where it and -M become unstable: the marks of w*.
  double mass = 0;
  model::MWidth edges;
  double highest_rad_per_s = 0;
};

/// L(s) of the continuous model (eq. 12) up to `highest_rad_per_s`.
BodeLoop ContinuousBode(const std::string& name, const RatioLoop& ratios, double highest_rad_per_s);

/// Magnitude and unwrapped phase over w in rad/s from 1 rad/s on. Marks w* of the positive and of the
/// negative mass: the phase of L there is -180 and, as L is drawn for the positive mass, 0 degrees.
plot::Chart BodeChart(const std::string& title, const std::vector<BodeLoop>& loops);

}  // namespace mwidth::figures
