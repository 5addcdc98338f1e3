#include "server/gate/state_refusals.h"

#include "server/gate/state_words.h"

namespace mwidth::gate {

using exchange::LoopStatus;

Refusal WrongState(const LoopStatus& status, const std::string& message) {
  return {.code = RefusalCode::kFailedPrecondition,
          .reason = kWrongState,
          .message = message,
          .metadata = {{"state", StateName(status.state)}}};
}

Refusal InFault(const LoopStatus& status) {
  return WrongState(status, "The axis is in FAULT. " + FaultMessage(status.fault));
}

Refusal StillStopping(const LoopStatus& status) {
  return WrongState(status, "The axis is still ramping down from a stop: ask again when it is READY.");
}

Refusal LoopSilent() {
  return {.code = RefusalCode::kUnavailable,
          .reason = kLoopSilent,
          .message =
              "The loop of this axis does not answer; it is told to stop rendering should it wake up. If "
              "the device moves, use the hardware's emergency stop; then look at the server's host."};
}

}  // namespace mwidth::gate
