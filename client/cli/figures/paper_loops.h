// The loops of the paper's figures.
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "client/cli/numbers.h"
#include "server/model/loop_parameters.h"

namespace mwidth::figures {

/// Table II: a Phantom Premium held by a hand, with a filter at `cutoff_hz`, at `rate_hz`.
inline model::LoopParameters TableTwoLoop(double rate_hz, double cutoff_hz) {
  return {.device_mass = 0.070,
          .device_damping = 0.005,
          .hand_damping = 5,
          .hand_stiffness = 700,
          .period_s = 1 / rate_hz,
          .cutoff_hz = cutoff_hz};
}

/// The loop of Figures 4, 5, 7 and 10, which is told by ratios, with Table II's device (eqs. 13, 14).
struct RatioLoop {
  double natural_rad_per_s = 100;  ///< w_n
  double damping_ratio = 0.5;      ///< zeta
  double cutoff_rad_per_s = 30;    ///< w0
  double period_s = 0.001;         ///< T
  double mass_ratio = 1;           ///< M/m

  model::LoopParameters Loop() const {
    const auto device = TableTwoLoop(1 / period_s, cutoff_rad_per_s / (2 * std::numbers::pi));
    auto loop = device;
    loop.hand_stiffness = device.device_mass * natural_rad_per_s * natural_rad_per_s;
    loop.hand_damping = 2 * damping_ratio * natural_rad_per_s * device.device_mass - device.device_damping;
    return loop;
  }
  double Mass() const { return mass_ratio * Loop().device_mass; }
};

/// "500 Hz", "M/m = -0.5".
inline std::string RateName(double rate_hz) { return cli::Rounded(rate_hz) + " Hz"; }
inline std::string MassName(double ratio) { return "M/m = " + cli::Rounded(ratio); }

/// `count` values at equal ratios, ends included.
inline std::vector<double> EqualRatios(double first, double last, int count) {
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    values.push_back(first * std::pow(last / first, static_cast<double>(i) / (count - 1)));
  }
  return values;
}

}  // namespace mwidth::figures
