#include "server/model/envelope.h"

#include <array>
#include <string>

namespace mwidth::model {
namespace {

// One corner of the envelope: every range's min or every range's max.
LoopParameters Corner(const LoopEnvelope& envelope, double ParameterRange::*end) {
  return {.device_mass = envelope.device.device_mass.*end,
          .device_damping = envelope.device.device_damping.*end,
          .hand_mass = envelope.hand.hand_mass.*end,
          .hand_damping = envelope.hand.hand_damping.*end,
          .hand_stiffness = envelope.hand.hand_stiffness.*end,
          .period_s = envelope.period_s,
          .cutoff_hz = envelope.cutoff_hz,
          .delay_s = envelope.delay_bound_s,
          .estimator = envelope.estimator,
          .accelerometer_bandwidth_hz = envelope.accelerometer_bandwidth_hz};
}

}  // namespace

LoopEnvelope EnvelopeOf(const LoopParameters& loop) {
  const auto point = [](double value) { return ParameterRange{.min = value, .max = value}; };
  return {.hand = {.hand_stiffness = point(loop.hand_stiffness),
                   .hand_damping = point(loop.hand_damping),
                   .hand_mass = point(loop.hand_mass)},
          .device = {.device_mass = point(loop.device_mass), .device_damping = point(loop.device_damping)},
          .period_s = loop.period_s,
          .cutoff_hz = loop.cutoff_hz,
          .delay_bound_s = loop.delay_s,
          .estimator = loop.estimator,
          .accelerometer_bandwidth_hz = loop.accelerometer_bandwidth_hz};
}

std::optional<ParameterError> Validate(const LoopEnvelope& envelope) {
  for (double ParameterRange::*end : {&ParameterRange::min, &ParameterRange::max}) {
    if (auto error = Validate(Corner(envelope, end))) {
      if (error->parameter == "delay_s") {
        error->parameter = "delay_bound_s";
      }
      return error;
    }
  }
  struct Named {
    const char* name;
    const ParameterRange& range;
  };
  const std::array<Named, 5> ranges{{{"device_mass", envelope.device.device_mass},
                                     {"device_damping", envelope.device.device_damping},
                                     {"hand_mass", envelope.hand.hand_mass},
                                     {"hand_damping", envelope.hand.hand_damping},
                                     {"hand_stiffness", envelope.hand.hand_stiffness}}};
  for (const auto& [name, range] : ranges) {
    if (range.min > range.max) {
      return ParameterError{
          name, range.min,
          "in a range that is not empty: its min at most its max (" + ParameterNumber(range.max) + ")"};
    }
  }
  return std::nullopt;
}

}  // namespace mwidth::model
