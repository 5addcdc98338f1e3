#include "server/rpc/convert.h"

#include <google/protobuf/util/time_util.h>

#include <cmath>
#include <numbers>

#include "server/gate/state_words.h"

namespace mwidth::rpc {
namespace {

using google::protobuf::util::TimeUtil;

v1::FaultKind Kind(exchange::Fault fault) {
  switch (fault) {
    case exchange::Fault::kNone:
      return v1::FAULT_KIND_UNSPECIFIED;
    case exchange::Fault::kEmergencyStop:
      return v1::FAULT_KIND_EMERGENCY_STOP;
    case exchange::Fault::kDriveSilent:
      return v1::FAULT_KIND_DRIVE_SILENT;
    case exchange::Fault::kNotFinite:
      return v1::FAULT_KIND_NOT_FINITE;
    case exchange::Fault::kPositionLimit:
      return v1::FAULT_KIND_POSITION_LIMIT;
    case exchange::Fault::kVelocityLimit:
      return v1::FAULT_KIND_VELOCITY_LIMIT;
    case exchange::Fault::kOverrun:
      return v1::FAULT_KIND_OVERRUN;
    case exchange::Fault::kDriveRefused:
      return v1::FAULT_KIND_DRIVE_REFUSED;
    case exchange::Fault::kNoDriveWatchdog:
      return v1::FAULT_KIND_NO_DRIVE_WATCHDOG;
    case exchange::Fault::kForeignTraffic:
      return v1::FAULT_KIND_FOREIGN_TRAFFIC;
    case exchange::Fault::kDriveError:
      return v1::FAULT_KIND_DRIVE_ERROR;
    case exchange::Fault::kForceSaturation:
      return v1::FAULT_KIND_FORCE_SATURATION;
    case exchange::Fault::kForceSlew:
      return v1::FAULT_KIND_FORCE_SLEW;
    case exchange::Fault::kEncoderJump:
      return v1::FAULT_KIND_ENCODER_JUMP;
    case exchange::Fault::kEncoderFreeze:
      return v1::FAULT_KIND_ENCODER_FREEZE;
    case exchange::Fault::kAccelerometer:
      return v1::FAULT_KIND_ACCELEROMETER;
    case exchange::Fault::kRepeatedOverrun:
      return v1::FAULT_KIND_REPEATED_OVERRUN;
    case exchange::Fault::kLoopDelay:
      return v1::FAULT_KIND_LOOP_DELAY;
    case exchange::Fault::kPositionGaps:
      return v1::FAULT_KIND_POSITION_GAPS;
    case exchange::Fault::kGrowingOscillation:
      return v1::FAULT_KIND_GROWING_OSCILLATION;
    case exchange::Fault::kEnergyExcess:
      return v1::FAULT_KIND_ENERGY_EXCESS;
  }
  return v1::FAULT_KIND_UNSPECIFIED;
}

v1::EstimatorKind Kind(model::EstimatorKind estimator) {
  switch (estimator) {
    case model::EstimatorKind::kFilteredDifference:
      return v1::ESTIMATOR_KIND_FILTERED_DIFFERENCE;
    case model::EstimatorKind::kLateFilteredDifference:
      return v1::ESTIMATOR_KIND_LATE_FILTERED_DIFFERENCE;
    case model::EstimatorKind::kButterworth:
      return v1::ESTIMATOR_KIND_BUTTERWORTH;
    case model::EstimatorKind::kKalman:
      return v1::ESTIMATOR_KIND_KALMAN;
    case model::EstimatorKind::kAccelerometer:
      return v1::ESTIMATOR_KIND_ACCELEROMETER;
    case model::EstimatorKind::kFilteredAccelerometer:
      return v1::ESTIMATOR_KIND_FILTERED_ACCELEROMETER;
  }
  return v1::ESTIMATOR_KIND_UNSPECIFIED;
}

void Convert(const model::ParameterRange& range, v1::ParameterRange& message) {
  message.set_min(range.min);
  message.set_max(range.max);
}

void Convert(const gate::Interval& interval, v1::Interval& message) {
  message.set_min(interval.min);
  message.set_max(interval.max);
  message.set_empty(interval.empty());
  message.set_empty_reason(interval.empty_reason);
}

}  // namespace

v1::State Convert(exchange::State state) {
  switch (state) {
    case exchange::State::kIdle:
      return v1::STATE_IDLE;
    case exchange::State::kReady:
      return v1::STATE_READY;
    case exchange::State::kRendering:
      return v1::STATE_RENDERING;
    case exchange::State::kFault:
      return v1::STATE_FAULT;
  }
  return v1::STATE_UNSPECIFIED;
}

void Convert(const exchange::FaultRecord& fault, v1::FaultInfo& message) {
  message.set_kind(Kind(fault.fault));
  message.set_tick(fault.tick);
  message.set_value(fault.value);
  message.set_limit(fault.limit);
  message.set_message(gate::FaultMessage(fault));
}

void Convert(const model::LoopParameters& loop, v1::LoopParameters& message) {
  message.set_device_mass(loop.device_mass);
  message.set_device_damping(loop.device_damping);
  message.set_hand_mass(loop.hand_mass);
  message.set_hand_damping(loop.hand_damping);
  message.set_hand_stiffness(loop.hand_stiffness);
  message.set_period_s(loop.period_s);
  message.set_cutoff_hz(loop.cutoff_hz);
  message.set_accelerometer_bandwidth_hz(loop.accelerometer_bandwidth_hz);
  message.set_delay_s(loop.delay_s);
  message.set_estimator(Kind(loop.estimator));
}

void Convert(const model::HandEnvelope& hand, v1::HandEnvelope& message) {
  Convert(hand.hand_stiffness, *message.mutable_stiffness());
  Convert(hand.hand_damping, *message.mutable_damping());
  Convert(hand.hand_mass, *message.mutable_mass());
  message.set_include_released_hand(hand.include_released_hand);
}

void Convert(const model::DeviceTolerance& device, v1::DeviceTolerance& message) {
  Convert(device.device_mass, *message.mutable_mass());
  Convert(device.device_damping, *message.mutable_damping());
}

void Convert(const model::Margins& margins, v1::StabilityMargins& message) {
  message.set_gain_db(20 * std::log10(margins.gain.value));
  message.set_gain_hz(margins.gain.critical_hz);
  message.set_phase_deg(margins.phase_rad.value * 180 / std::numbers::pi);
  message.set_phase_hz(margins.phase_rad.critical_hz);
  message.set_delay_s(margins.delay.seconds);
  message.set_delay_hz(margins.delay.critical_hz);
  message.set_delay_at_least(margins.delay.at_least);
  message.set_modulus(margins.modulus.value);
  message.set_modulus_hz(margins.modulus.critical_hz);
}

void Convert(const gate::MassRange& range, v1::MWidth& message) {
  Convert(range.nominal, *message.mutable_nominal());
  Convert(range.robust, *message.mutable_robust());
  Convert(range.admitted, *message.mutable_admitted());
  message.set_min_critical_hz(range.min_critical_hz);
  message.set_max_critical_hz(range.max_critical_hz);
  message.set_required_gain_margin_db(range.required_gain_margin_db);
  if (range.min_binding) {
    Convert(*range.min_binding, *message.mutable_min_binding());
  }
  if (range.max_binding) {
    Convert(*range.max_binding, *message.mutable_max_binding());
  }
}

void Convert(const gate::StabilityReport& report, v1::StabilityReport& message) {
  message.set_requested_mass(report.requested_mass);
  Convert(report.range, *message.mutable_m_width());
  Convert(report.loop, *message.mutable_loop());
  message.set_gain_margin_db(report.gain_margin_db);
  message.set_critical_hz(report.critical_hz);
  message.set_binding(report.binding);
  message.set_nearest_admitted_mass(report.nearest_admitted_mass);
  if (report.admitting_cutoff_hz) {
    message.set_admitting_cutoff_hz(*report.admitting_cutoff_hz);
  }
  Convert(report.margins, *message.mutable_margins());
}

void Convert(const gate::AxisDescription& axis, v1::AxisInfo& message) {
  message.set_name(axis.name);
  message.set_kind(axis.kind == model::AxisKind::kLinear ? v1::AXIS_KIND_LINEAR : v1::AXIS_KIND_ROTARY);
  message.set_mass_min(axis.mass_min);
  message.set_mass_max(axis.mass_max);
  message.set_force_limit(axis.force_limit);
  message.set_simulated(axis.simulated);
  message.set_position_quantum(axis.position_quantum);
  message.set_acceleration_quantum(axis.acceleration_quantum);
  if (axis.force_noise_limit) {
    message.set_force_noise_limit(*axis.force_noise_limit);
  }
  if (axis.hand_envelope) {
    Convert(*axis.hand_envelope, *message.mutable_envelope());
  }
  if (axis.device_tolerance) {
    Convert(*axis.device_tolerance, *message.mutable_tolerance());
  }
}

void Convert(const gate::Lease& lease, v1::ControlLease& message) {
  message.set_lease_id(lease.id);
  *message.mutable_ttl() = TimeUtil::NanosecondsToDuration(lease.ttl_ns);
  *message.mutable_expire_time() = TimeUtil::GetCurrentTime() + message.ttl();
}

std::optional<model::EstimatorKind> Estimator(v1::EstimatorKind estimator) {
  switch (estimator) {
    case v1::ESTIMATOR_KIND_FILTERED_DIFFERENCE:
      return model::EstimatorKind::kFilteredDifference;
    case v1::ESTIMATOR_KIND_LATE_FILTERED_DIFFERENCE:
      return model::EstimatorKind::kLateFilteredDifference;
    case v1::ESTIMATOR_KIND_BUTTERWORTH:
      return model::EstimatorKind::kButterworth;
    case v1::ESTIMATOR_KIND_KALMAN:
      return model::EstimatorKind::kKalman;
    case v1::ESTIMATOR_KIND_ACCELEROMETER:
      return model::EstimatorKind::kAccelerometer;
    case v1::ESTIMATOR_KIND_FILTERED_ACCELEROMETER:
      return model::EstimatorKind::kFilteredAccelerometer;
    default:
      return std::nullopt;
  }
}

model::LoopParameters Override(model::LoopParameters own, const v1::LoopParameters& overrides) {
  const auto replace = [](double& value, bool set, double other) {
    if (set) {
      value = other;
    }
  };
  replace(own.device_mass, overrides.has_device_mass(), overrides.device_mass());
  replace(own.device_damping, overrides.has_device_damping(), overrides.device_damping());
  replace(own.hand_mass, overrides.has_hand_mass(), overrides.hand_mass());
  replace(own.hand_damping, overrides.has_hand_damping(), overrides.hand_damping());
  replace(own.hand_stiffness, overrides.has_hand_stiffness(), overrides.hand_stiffness());
  replace(own.period_s, overrides.has_period_s(), overrides.period_s());
  replace(own.cutoff_hz, overrides.has_cutoff_hz(), overrides.cutoff_hz());
  replace(own.delay_s, overrides.has_delay_s(), overrides.delay_s());
  replace(own.accelerometer_bandwidth_hz, overrides.has_accelerometer_bandwidth_hz(),
          overrides.accelerometer_bandwidth_hz());
  own.estimator = Estimator(overrides.estimator()).value_or(own.estimator);
  return own;
}

double Seconds(const google::protobuf::Duration& duration) {
  return static_cast<double>(duration.seconds()) + 1e-9 * duration.nanos();
}

}  // namespace mwidth::rpc
