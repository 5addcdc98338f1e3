// The parameters of a rendering loop, and what is allowed for each.
//
//   symbol (paper)   field             meaning
//   m                device_mass       inertia of the device; kg or kg m^2
//   b                device_damping    viscous damping of the device; N s/m or N m s/rad
//   m_h              hand_mass         inertia of the hand, rigidly added to m (0 in the paper)
//   b_h              hand_damping      damping between hand and device
//   k_h              hand_stiffness    stiffness between hand and device; N/m or N m/rad
//   T                period_s          sample period
//   f0 = w0/2 pi     cutoff_hz         cut-off of the estimator's low-pass filter, eq. 4
//   d T + r T        delay_s           loop delay beyond the zero-order hold (0 in the paper)
//   H(z)             estimator         the low-pass filter behind the double difference, or an accelerometer
//   w_a/2 pi         accelerometer_bandwidth_hz   of the sensor itself; of accelerometers only
#pragma once

#include <optional>
#include <string>

#include "server/model/estimator_kind.h"

namespace mwidth::model {

struct LoopParameters {
  double device_mass = 0;
  double device_damping = 0;
  double hand_mass = 0;
  double hand_damping = 0;
  double hand_stiffness = 0;
  double period_s = 0;
  double cutoff_hz = 0;
  double delay_s = 0;
  EstimatorKind estimator = EstimatorKind::kFilteredDifference;
  double accelerometer_bandwidth_hz = 0;
};

/// A number as messages about parameters have it: the shortest form of at most ten digits. Any thread.
std::string ParameterNumber(double value);

/// A parameter that is not finite or out of range.
struct ParameterError {
  /// Field of LoopParameters, or another argument's name.
  std::string parameter;
  double value = 0;
  /// For a person, such as "0 to 3 periods (0.003 s)".
  std::string allowed;

  /// One sentence with all three.
  std::string Message() const;
};

/// The first parameter that the model does not support, if any: device_mass 1e-6..1e4; device_damping,
/// hand_mass, hand_damping 0..1e4; hand_stiffness 0..1e6; period_s 1e-5..1e-2; estimator one of
/// kEstimatorKinds or kAccelerometerKinds; cutoff_hz above 0, at most 0.5/period_s, within
/// CutoffRangeOf(estimator); accelerometer_bandwidth_hz 0.1..1e6 for an accelerometer, anything for the
/// others, which do not use it; delay_s 0..3 period_s.
std::optional<ParameterError> Validate(const LoopParameters& loop);

}  // namespace mwidth::model
