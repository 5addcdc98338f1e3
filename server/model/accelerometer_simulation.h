// The paper's hybrid model with an accelerometer on the device, stepped exactly.
//
//   y' = w_a (x'' - y)          y(kT) sampled, with X(k)
#pragma once

#include "server/model/delayed_force.h"
#include "server/model/hybrid_simulation.h"
#include "server/model/loop_parameters.h"

namespace mwidth::model {

/// HybridSimulation and the sensor beside it, each stepped exactly, with the same functions and the same
/// units. One thread.
class AccelerometerSimulation {
 public:
  /// At rest, the sensor too. Precondition: Validate(loop) is empty and IsAccelerometer(loop.estimator).
  explicit AccelerometerSimulation(const LoopParameters& loop);

  /// As HybridSimulation's; the sensor tells 0. Rt.
  void Reset(double position, double velocity, double hand_position) noexcept;
  /// Rt.
  void Command(double force) noexcept {
    device_.Command(force);
    force_.Command(force);
  }
  /// Rt.
  double Advance(double hand_position_next) noexcept;
  /// Rt.
  double AdvanceUnder(double drive, double drive_middle, double drive_next) noexcept;

  double position() const noexcept { return device_.position(); }
  double velocity() const noexcept { return device_.velocity(); }
  double hand_position() const noexcept { return device_.hand_position(); }
  /// What the sensor tells now; m/s^2 or rad/s^2.
  double sensed() const noexcept { return sensed_; }

 private:
  /// What the sensor tells at the end of a tick, per unit of what drives device and sensor.
  struct Growth {
    double kept = 0;         ///< what it told at the beginning
    double stretch = 0;      ///< position less hand position
    double velocity = 0;     ///< velocity
    double hand_step = 0;    ///< way of the hand during the tick
    double older_force = 0;  ///< force that acts until the delay's fraction has passed
    double newer_force = 0;  ///< force that acts after it
    double drive = 0;        ///< drive of the hand at the beginning of the tick
    double drive_slope = 0;  ///< its slope there, per tick
    double drive_bend = 0;   ///< its second derivative, per tick squared
  };
  /// One tick of the sensor, of a device that has not moved yet.
  void Sense(double hand_pull) noexcept;

  HybridSimulation device_;
  Growth growth_;
  DelayedForce force_;
  double sensed_ = 0;
};

}  // namespace mwidth::model
