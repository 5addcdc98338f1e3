// How the mass held by a hand moves in a given time.
#pragma once

namespace mwidth::model {

/// Free and forced responses at one time of the mass, damper and spring. Every motion under a force that is
/// linear or quadratic in time is a combination of these numbers.
struct PlantResponse {
  /// Response of position to a unit impulse, a unit step, a unit ramp and a parabola t^2/2 of acceleration;
  /// s, s^2, s^3, s^4.
  double impulse = 0;
  double step = 0;
  double ramp = 0;
  double parabola = 0;
  /// What a unit velocity has lost. The free motion from x0 and v0 is
  ///   x(t) = x0 - stiffness_rate step x0 + impulse v0,
  ///   v(t) = v0 - velocity_loss v0 - stiffness_rate impulse x0.
  double velocity_loss = 0;
};

/// Response at `time_s` of x'' + damping_rate x' + stiffness_rate x = a(t), with damping_rate (1/s) and
/// stiffness_rate (1/s^2) at least 0, also both 0. Exact for any damping: a Taylor series over a time short
/// against both rates, then doublings x(2t) = x(t) after x(t), arranged so that small losses keep their
/// relative accuracy. Rt.
PlantResponse RespondAfter(double time_s, double damping_rate, double stiffness_rate) noexcept;

}  // namespace mwidth::model
