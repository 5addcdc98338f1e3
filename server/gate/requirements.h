// What a mass must keep to be admitted: the assumptions behind the robust interval, and what is asked beyond
// it.
#pragma once

#include <optional>

#include "server/gate/force_noise_limit.h"
#include "server/model/envelope.h"
#include "server/model/loop_parameters.h"

namespace mwidth::gate {

/// Units as in model::LoopParameters.
struct Requirements {
  /// 0 to 60 dB, kept from the edge of the robust interval.
  double gain_margin_db = 0;
  /// None where any noise is allowed.
  std::optional<ForceNoiseLimit> noise_limit{};
  /// Hands and devices that may stand there; none: exactly those of the loop.
  std::optional<model::HandEnvelope> hand{};
  std::optional<model::DeviceTolerance> device{};
  /// Delay beyond the loop's own that the loop delay watch lets pass; 0 or more.
  double delay_tolerance_s = 0;
};

/// Every loop that a mass must be stable with: hands and devices as required, any delay from 0 to that of
/// `loop`, with an accelerometer to that and the tolerance. From positions the tolerance is put down to the
/// margins of a mass. An accelerometer's edge at half the sample rate does not outlive a fraction of a tick,
/// which no gain margin covers.
/// Where the sum is beyond what the model knows, 3 periods, model::Validate refuses the answer.
model::LoopEnvelope AssumedLoops(const model::LoopParameters& loop, const Requirements& requirements);

/// True where those are one loop, `loop` itself.
bool AssumesOneLoop(const model::LoopParameters& loop, const Requirements& requirements);

}  // namespace mwidth::gate
