// A device sliding one way against Coulomb friction: when it comes to rest.
//
//   symbol   meaning
//   s        direction of the slide, +1 or -1; friction is s F_c all along it
//   I, S     impulse and step response of the mass, damper and spring (PlantResponse)
//   a_0      acceleration at the start of the slide
//   j_0      pull of the spring's end on the start: (k/mu)(hand's velocity - v_0)
//
//   v(t) = v_0 + a_0 I(t) + j_0 S(t)        v'(t) = a_0 I'(t) + j_0 I(t)
//
// v' is a free motion of the same mass, damper and spring: where it is zero is known in closed form, and
// between its zeros v runs one way. The swing of v about the hand's velocity decays, so if v meets zero at
// all, it does so on its way to its first turn on that side. There a bracketed Newton iteration finds it.
#pragma once

#include <optional>

#include "server/model/plant_response.h"

namespace mwidth::model {

/// v_0, a_0, j_0 and s.
struct Slide {
  double velocity = 0;
  double acceleration = 0;
  double pull_rate = 0;
  double direction = 1;
};

/// Damping and stiffness per mass, with what follows from them for the times at which v' is zero.
class SlidingPlant {
 public:
  /// `damping_rate` (1/s) and `stiffness_rate` (1/s^2) at least 0, also both 0.
  SlidingPlant(double damping_rate, double stiffness_rate) noexcept;

  double damping_rate() const noexcept { return damping_rate_; }
  double stiffness_rate() const noexcept { return stiffness_rate_; }
  /// See RespondAfter. Rt.
  PlantResponse After(double time_s) const noexcept {
    return RespondAfter(time_s, damping_rate_, stiffness_rate_);
  }

  /// First time in (0, time_s] at which the slide's velocity is 0, if any; `at_end` is After(time_s).
  /// Precondition: velocity has the slide's direction, or is 0 and leaves 0 in that direction. Rounding moves
  /// it by no more than it moves v. None where the motion is not finite. Rt.
  std::optional<double> FindStop(const Slide& slide, double time_s,
                                 const PlantResponse& at_end) const noexcept;

 private:
  /// First time above 0 at which v' is 0; infinite where there is none.
  double FirstTurn(const Slide& slide) const noexcept;

  double damping_rate_;
  double stiffness_rate_;
  /// Of v', above 0 where it swings; then the time between its zeros is pi over it.
  double angular_frequency_ = 0;
  /// Half the difference of the two rates of decay, and the slower one, where it does not swing.
  double half_difference_ = 0;
  double slow_rate_ = 0;
};

}  // namespace mwidth::model
