// What is assumed of the hand, and how far the motion may part from it.
#pragma once

namespace mwidth::render {

/// What the monitor assumes, and its thresholds. Units are the axis's: kg, m, N or kg m^2, rad, N m.
struct HandMonitorConfig {
  bool enabled = true;
  /// Least inertia and least damping of the device alone; at least 0.
  double device_mass = 0;
  double device_damping = 0;
  /// Least damping of the device and a hand that holds it, of those that the masses are certified for.
  double least_damping = 0;

  /// Least swing of the force, peak to peak, in parts of the force limit; 0.01 to 1. Below it nothing is
  /// judged.
  double min_swing = 0.05;
  /// Least growth of an oscillation in one period, as a factor; 1 to 2.
  double min_growth = 1.02;
  /// Share of the motion that one growing mode may leave unexplained, for every half-cycle that is looked
  /// back over beyond the second, in parts of its variance; 0 to 0.1.
  double max_unexplained = 0.006;
  /// Power that the hand itself may seem to put in, in parts of what least_damping takes out; 0 to 1.
  double max_push = 0.1;
  /// Energy that the rendered force may put into the motion, in parts of what least_damping takes out; 1
  /// to 10.
  double max_energy_ratio = 1.2;
  /// Least swing of the force for the energy balance, peak to peak, in parts of the force limit; 0.05 to 2.
  double energy_swing = 0.4;
};

}  // namespace mwidth::render
