// Which hands, devices and delays a rendered mass must be stable with: the assumptions of a robust interval.
#pragma once

#include <optional>

#include "server/model/loop_parameters.h"

namespace mwidth::model {

/// From min to max, both included; a point where they are equal.
struct ParameterRange {
  double min = 0;
  double max = 0;

  bool operator==(const ParameterRange&) const = default;
};

/// The person's hold on the device: any stiffness, damping and mass of the box, independently.
struct HandEnvelope {
  ParameterRange hand_stiffness;
  ParameterRange hand_damping;
  ParameterRange hand_mass;
  /// Also a hand that has let go: no stiffness and no damping, with any mass from 0 to hand_mass.max still
  /// resting on the device.
  bool include_released_hand = false;

  bool operator==(const HandEnvelope&) const = default;
};

/// How well the device is known.
struct DeviceTolerance {
  ParameterRange device_mass;
  ParameterRange device_damping;

  bool operator==(const DeviceTolerance&) const = default;
};

/// Everything a robust interval assumes of the loop. Units as in LoopParameters.
struct LoopEnvelope {
  HandEnvelope hand;
  DeviceTolerance device;
  double period_s = 0;
  double cutoff_hz = 0;
  /// The delay may be anything from 0 to this.
  double delay_bound_s = 0;
  EstimatorKind estimator = EstimatorKind::kFilteredDifference;
  /// Of the sensor itself; of accelerometers only.
  double accelerometer_bandwidth_hz = 0;

  bool operator==(const LoopEnvelope&) const = default;
};

/// The envelope that holds one hand, one device and, unless its delay is 0, every delay up to it.
LoopEnvelope EnvelopeOf(const LoopParameters& loop);

/// The first parameter that is not finite, out of range (Validate of loop_parameters.h has the ranges) or
/// whose range is empty, min above max.
/// ParameterError::parameter is the field's name in the structs above.
std::optional<ParameterError> Validate(const LoopEnvelope& envelope);

}  // namespace mwidth::model
