// What an accelerometer of first-order bandwidth tells of the held mass after a given time.
//
//   x'' + c x' + k x = a(t)      y' = l (x'' - y)
//
// with c the damping rate, k the stiffness rate and l = 2 pi times the sensor's bandwidth; h, Phi are impulse
// and step response of x. A unit step of a(t) makes the sensor tell y(t), the low-passed h'.
#pragma once

namespace mwidth::model {

/// The motion and what is sensed of it, all from rest, in any unit of time.
struct AccelerometerResponse {
  double impulse = 0;  ///< h, the velocity after a unit step of acceleration
  double step = 0;     ///< Phi
  /// h' = 1 - k Phi - c h, to the accuracy of the largest of its terms.
  double slope = 1;
  /// 1 - e^(-c t) - c h, what the spring takes from the velocity; exactly 0 without stiffness, and accurate
  /// relative to itself otherwise, however strong the damping.
  double spring_loss = 0;
  /// e^(-l t): what the sensor keeps of what it told.
  double kept = 1;
  /// y after a unit step, a unit ramp and a parabola t^2/2: each the integral of the one before. After a unit
  /// velocity at the beginning the sensor tells -c after_step - k after_ramp, after a unit position -k
  /// after_step.
  double after_step = 0;
  double after_ramp = 0;
  double after_parabola = 0;
};

/// Response at `time`, above 0, with rates at least 0 and `sensor_rate` above 0. Exact for any rates, also
/// equal ones: a Taylor series over a time short against all of them, then doublings. Each doubling adds a
/// few roundings, so that the result is good to some 1e-14 of its largest term. Any thread. Rt.
AccelerometerResponse SenseAfter(double time, double damping_rate, double stiffness_rate,
                                 double sensor_rate) noexcept;

}  // namespace mwidth::model
