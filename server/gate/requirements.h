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
};

/// Every loop that a mass must be stable with: hands and devices as required, any delay from 0 to that of
/// `loop`.
model::LoopEnvelope AssumedLoops(const model::LoopParameters& loop, const Requirements& requirements);

/// True where those are one loop, `loop` itself.
bool AssumesOneLoop(const model::LoopParameters& loop, const Requirements& requirements);

}  // namespace mwidth::gate
