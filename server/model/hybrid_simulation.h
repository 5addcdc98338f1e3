// The paper's hybrid model, stepped exactly: a continuous hand and device under a staircase force.
//
//   x'' (m + m_h) + x' (b + b_h) + k_h x = k_h x_h + b_h x_h' - F_a          (eqs. 1, 2)
//
//   t      kT                kT + delay                         (k+1)T
//   x      X(k) sampled                                         X(k+1) sampled
//   F_a    ...older force ->|F_a(k), computed from X(k) ------->| holds until (k+1)T + delay
//   x_h    straight line from the hand's sample at kT to its sample at (k+1)T
#pragma once

#include <array>
#include <cstddef>

#include "server/model/loop_parameters.h"

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
/// relative accuracy.
PlantResponse RespondAfter(double time_s, double damping_rate, double stiffness_rate);

/// One device held by one hand. Each tick: read position(), call Command with the force computed from it,
/// then Advance to the next tick. Positions in m or rad, velocities per second, forces in N or N m.
class HybridSimulation {
 public:
  /// Precomputes one tick. Precondition: Validate(loop) is empty; cutoff_hz is not used. At rest at 0, hand
  /// at 0.
  explicit HybridSimulation(const LoopParameters& loop);

  /// Puts the device at `position` with `velocity` and the hand at `hand_position`; all forces, also those
  /// still on their way through the delay, become 0. Rt.
  void Reset(double position, double velocity, double hand_position) noexcept;
  /// Sets F_a(k), which acts against the positive direction from kT + delay on, and stays in force until the
  /// next command. Rt.
  void Command(double force) noexcept { commands_[0] = force; }
  /// Steps from kT to (k+1)T while the hand moves to `hand_position_next`; returns X(k+1). Exact up to
  /// rounding. Rt.
  double Advance(double hand_position_next) noexcept;
  /// The same under a hand drive b_h x_h' + k_h x_h, in N or N m, that is the parabola through its values at
  /// the beginning, the middle and the end of the tick. hand_position() stays, and the spring counts from it:
  /// reset it to 0. Made for a smooth motion of the hand, of which a polygon would falsify the velocity. Rt.
  double AdvanceUnder(double drive, double drive_middle, double drive_next) noexcept;

  double position() const noexcept { return position_; }
  double velocity() const noexcept { return velocity_; }
  double hand_position() const noexcept { return hand_position_; }

 private:
  /// How one quantity grows over one tick, per unit of what drives it.
  struct Growth {
    double stretch = 0;      ///< position less hand position
    double velocity = 0;     ///< velocity
    double hand_step = 0;    ///< way of the hand during the tick
    double older_force = 0;  ///< force that acts until the delay's fraction has passed
    double newer_force = 0;  ///< force that acts after it
    double drive = 0;        ///< drive of the hand at the beginning of the tick
    double drive_slope = 0;  ///< its slope there, per tick
    double drive_bend = 0;   ///< its second derivative, per tick squared
  };
  /// What changes the hand's pull during one tick.
  struct HandInput {
    double step = 0;
    double drive = 0;
    double drive_slope = 0;
    double drive_bend = 0;
  };
  double Over(const Growth& growth, const HandInput& hand) const noexcept;
  double Step(const HandInput& hand) noexcept;

  /// Validate allows a delay of 3 periods: F_a(k) to F_a(k-4) can act during tick k.
  static constexpr std::size_t kCommands = 5;

  Growth position_growth_;
  Growth velocity_growth_;
  /// Whole ticks of the delay: commands_[delay_ticks_] is the newer force, the one behind it the older.
  std::size_t delay_ticks_ = 0;
  double position_ = 0;
  double velocity_ = 0;
  double hand_position_ = 0;
  /// F_a(k), F_a(k-1), ...
  std::array<double, kCommands> commands_{};
};

}  // namespace mwidth::model
