// What an axis is, as far as it never changes while the server runs.
#pragma once

#include <limits>
#include <optional>
#include <string>

#include "server/gate/requirements.h"
#include "server/model/axis_kind.h"
#include "server/model/loop_parameters.h"

namespace mwidth::gate {

/// Units are those of `kind`: kg, m, N or kg m^2, rad, N m.
struct AxisDescription {
  std::string name;
  model::AxisKind kind = model::AxisKind::kLinear;
  /// The loop as configured, its filter until SetFilter; model::Validate accepts it.
  model::LoopParameters loop;
  /// Bounds on any virtual mass, edges included, whatever the stability model says; they hold 0 between them.
  double mass_min = 0;
  double mass_max = 0;
  /// The commanded force never exceeds this magnitude, nor changes faster than this a second; infinite: any.
  double force_limit = 0;
  double force_slew_limit = std::numeric_limits<double>::infinity();
  /// 0 or more; what an admitted mass keeps from the edge of the M-width.
  double required_gain_margin_db = 0;
  /// Position of one encoder count; m or rad.
  double position_quantum = 0;
  /// Force of one count of the drive; N or N m.
  double force_quantum = 0;
  /// Acceleration of one count of the accelerometer, m/s^2 or rad/s^2; its bandwidth is in `loop`. 0 where
  /// there is none: then no estimator that reads one is granted.
  double acceleration_quantum = 0;
  /// Largest standard deviation of the force that the counts of the encoder, or of the accelerometer, may
  /// cause; none: any.
  std::optional<double> force_noise_limit{};
  /// Hands and devices that every admitted mass is stable with; none: exactly those of `loop`.
  std::optional<model::HandEnvelope> hand_envelope{};
  std::optional<model::DeviceTolerance> device_tolerance{};
  /// Delay beyond that of `loop` that the loop delay watch lets pass, s; 0 or more.
  double delay_tolerance_s = 0;
  bool simulated = false;
  /// Whether the loop has real-time scheduling and, if not, why and how to change it.
  bool realtime = false;
  std::string realtime_message;
  /// Why this axis must not render, with what to do about it; empty where it may. A real drive without
  /// real-time scheduling is one reason.
  std::string rendering_blocked_reason;

  /// What every admitted mass keeps.
  gate::Requirements Requirements() const {
    const auto noise =
        force_noise_limit
            ? std::optional(ForceNoiseLimit{position_quantum, *force_noise_limit, acceleration_quantum})
            : std::nullopt;
    return {required_gain_margin_db, noise, hand_envelope, device_tolerance, delay_tolerance_s};
  }
};

}  // namespace mwidth::gate
