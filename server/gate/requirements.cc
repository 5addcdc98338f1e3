#include "server/gate/requirements.h"

namespace mwidth::gate {

model::LoopEnvelope AssumedLoops(const model::LoopParameters& loop, const Requirements& requirements) {
  model::LoopEnvelope envelope = model::EnvelopeOf(loop);
  envelope.hand = requirements.hand.value_or(envelope.hand);
  envelope.device = requirements.device.value_or(envelope.device);
  if (model::IsAccelerometer(loop.estimator)) {
    envelope.delay_bound_s += requirements.delay_tolerance_s;
  }
  return envelope;
}

bool AssumesOneLoop(const model::LoopParameters& loop, const Requirements& requirements) {
  const model::LoopEnvelope assumed = AssumedLoops(loop, requirements);
  return assumed.delay_bound_s == 0 && assumed == model::EnvelopeOf(loop);
}

}  // namespace mwidth::gate
