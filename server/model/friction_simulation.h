// The hybrid model with Coulomb friction in the device, stepped exactly from event to event.
//
//   x'' (m + m_h) + x' (b + b_h) + k_h x = k_h x_h + b_h x_h' - F_a - F_f      (eqs. 1, 2, and friction)
//
//   sliding    F_f = F_c sign(x')
//   sticking   x' = 0 and F_f is whatever holds it, while that is at most F_c
//
// Within a tick the pull on the device is a staircase plus a straight line, so each slide has the closed form
// of HybridSimulation, its end is found in slide.h, and the time until a sticking device breaks loose follows
// from a straight line meeting F_c. There is no time step but the tick. Friction that breaks loose at more
// than it slides with (stiction, Stribeck) is not modelled.
#pragma once

#include "server/model/delayed_force.h"
#include "server/model/hybrid_simulation.h"
#include "server/model/loop_parameters.h"
#include "server/model/slide.h"

namespace mwidth::model {

/// HybridSimulation's interface and units. Events within a tick: at most a few for each half swing of the
/// device on its spring, so a tick takes bounded time, which grows only where many swings fit into one tick.
class FrictionSimulation {
 public:
  /// `coulomb_friction` F_c in N or N m, finite, at least 0. Other preconditions as HybridSimulation. Where
  /// loop.estimator is an accelerometer, that is stepped along.
  FrictionSimulation(const LoopParameters& loop, double coulomb_friction) noexcept;

  /// As HybridSimulation's. Rt.
  void Reset(double position, double velocity, double hand_position) noexcept;
  /// As HybridSimulation's. Rt.
  void Command(double force) noexcept { force_.Command(force); }
  /// As HybridSimulation's; a device at rest has a velocity of exactly 0. Rt.
  double Advance(double hand_position_next) noexcept;

  double position() const noexcept { return position_; }
  double velocity() const noexcept { return velocity_; }
  double hand_position() const noexcept { return hand_position_; }
  /// What the accelerometer tells now, m/s^2 or rad/s^2; 0 without one.
  double sensed() const noexcept { return sensed_; }

 private:
  /// A part of the tick under one force, and the plant's response over the whole of it.
  struct Part {
    double time_s = 0;
    PlantResponse response;
  };

  void Pass(const Part& part, double force) noexcept;
  /// Acceleration that hand and motor would give to the device at rest, without friction.
  double Pull(double force) const noexcept;
  /// How long the device sticks, at most `time_s`, when it is at rest under `pull`.
  double StickingTime(double pull, double time_s) const noexcept;
  /// Slides in `direction` until `part` is over or the device stops; returns the time left. `sliding_pull`
  /// is the pull less friction.
  double SlideOn(double direction, double sliding_pull, const Part& part) noexcept;
  /// What the accelerometer tells after a slide or a rest of `time_s` from now, under an acceleration and its
  /// slope: exactly, as AccelerometerSimulation.
  void Sense(double time_s, double acceleration, double acceleration_rate) noexcept;
  void MoveHand(double time_s) noexcept { hand_position_ += hand_velocity_ * time_s; }

  SlidingPlant plant_;
  double period_s_;
  double mass_;
  /// b_h and F_c per mass.
  double hand_damping_rate_;
  double friction_;
  /// w_a; 0 without an accelerometer.
  double sensor_rate_;
  DelayedForce force_;
  Part early_;
  Part late_;
  double position_ = 0;
  double velocity_ = 0;
  double hand_position_ = 0;
  double hand_velocity_ = 0;
  double sensed_ = 0;
};

}  // namespace mwidth::model
