// How truly and how quietly a mass is rendered.
#pragma once

#include <optional>
#include <string>

#include "server/model/accuracy.h"
#include "server/model/loop_parameters.h"

namespace mwidth::gate {

/// What SetMass tells of a mass: the band of everyday reaching, as in Figure 9 of the paper.
inline constexpr model::MotionBand kDefaultBand{.lowest_hz = 0.1, .highest_hz = 5, .duration_s = 60};

/// kg or kg m^2, N or N m. Figures that do not exist are missing: never NaN.
struct MassAccuracy {
  /// What the person should feel: m + M.
  double ideal_mass = 0;
  /// Least-squares perceived mass over the band and its error relative to ideal_mass, predicted (eqs. 23,
  /// 24).
  std::optional<double> perceived_mass{};
  std::optional<double> error{};
  /// The same by exact simulation, where it was asked for.
  std::optional<double> simulated_perceived_mass{};
  std::optional<double> simulated_error{};
  /// Standard deviation of the force that the quantum of the encoder, or of the accelerometer, causes.
  /// Missing where the accelerometer's is not known.
  std::optional<double> force_noise{};
  /// A sentence where a figure is missing that was asked for.
  std::string unavailable_reason{};
};

/// Predicts the accuracy of `mass`, finite, with an encoder of `position_quantum`, m or rad, and an
/// accelerometer of `acceleration_quantum`, m/s^2 or rad/s^2, where the loop reads one; both at least 0, the
/// latter 0 where it is not known.
/// Precondition: model::Validate accepts loop and band. Any thread, some 20 us.
MassAccuracy PredictAccuracy(const model::LoopParameters& loop, double mass, const model::MotionBand& band,
                             double position_quantum, double acceleration_quantum = 0);

/// Adds the simulated figures for the same loop, mass and band. Any thread; up to seconds.
void SimulateAccuracy(const model::LoopParameters& loop, double mass, const model::MotionBand& band,
                      MassAccuracy& accuracy);

}  // namespace mwidth::gate
