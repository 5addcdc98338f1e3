// The paper's hybrid model, stepped exactly: a continuous hand and device under a staircase force.
//
//   x'' (m + m_h) + x' (b + b_h) + k_h x = k_h x_h + b_h x_h' - F_a          (eqs. 1, 2)
//
//   t      kT                kT + delay                         (k+1)T
//   x      X(k) sampled                                         X(k+1) sampled
//   F_a    ...older force ->|F_a(k), computed from X(k) ------->| holds until (k+1)T + delay
//   x_h    straight line from the hand's sample at kT to its sample at (k+1)T
#pragma once

#include "server/model/delayed_force.h"
#include "server/model/loop_parameters.h"
#include "server/model/plant_response.h"

namespace mwidth::model {

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
  void Command(double force) noexcept { force_.Command(force); }
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
  double Over(const Growth& growth, double hand_pull) const noexcept;
  /// One tick; what the hand's pull adds to position and velocity.
  double Step(double position_pull, double velocity_pull) noexcept;

  Growth position_growth_;
  Growth velocity_growth_;
  double position_ = 0;
  double velocity_ = 0;
  double hand_position_ = 0;
  DelayedForce force_;
};

// Inline, because a simulation is little but this, and a call would cost as much as the arithmetic.

inline double HybridSimulation::Over(const Growth& growth, double hand_pull) const noexcept {
  // The newest force last: everything else is known while the loop still computes it.
  return growth.stretch * (position_ - hand_position_) + growth.velocity * velocity_ + hand_pull +
         growth.older_force * force_.older() + growth.newer_force * force_.newer();
}

inline double HybridSimulation::Step(double position_pull, double velocity_pull) noexcept {
  force_.Start();
  const double position_gain = Over(position_growth_, position_pull);
  const double velocity_gain = Over(velocity_growth_, velocity_pull);
  // Gains are added, not whole values multiplied: at 10 us a tick changes the position by parts in 1e12.
  position_ += position_gain;
  velocity_ += velocity_gain;
  return position_;
}

inline double HybridSimulation::Advance(double hand_position_next) noexcept {
  const double hand_step = hand_position_next - hand_position_;
  const double position =
      Step(position_growth_.hand_step * hand_step, velocity_growth_.hand_step * hand_step);
  hand_position_ = hand_position_next;
  return position;
}

}  // namespace mwidth::model
