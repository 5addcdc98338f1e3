#include "server/gate/requirements.h"

namespace mwidth::gate {

model::LoopEnvelope AssumedLoops(const model::LoopParameters& loop, const Requirements& requirements) {
  model::LoopEnvelope envelope = model::EnvelopeOf(loop);
  envelope.hand = requirements.hand.value_or(envelope.hand);
  envelope.device = requirements.device.value_or(envelope.device);
  return envelope;
}

bool AssumesOneLoop(const model::LoopParameters& loop, const Requirements& requirements) {
  return loop.delay_s == 0 && AssumedLoops(loop, requirements) == model::EnvelopeOf(loop);
}

}  // namespace mwidth::gate
