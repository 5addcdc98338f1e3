#include "server/gate/state_words.h"

#include "server/gate/figures.h"

namespace mwidth::gate {

std::string StateName(exchange::State state) {
  switch (state) {
    case exchange::State::kIdle:
      return "IDLE";
    case exchange::State::kReady:
      return "READY";
    case exchange::State::kRendering:
      return "RENDERING";
    case exchange::State::kFault:
      return "FAULT";
  }
  return "unknown";
}

std::string FaultMessage(const exchange::FaultRecord& fault) {
  const std::string value = Figure(fault.value);
  const std::string limit = Figure(fault.limit);
  switch (fault.fault) {
    case exchange::Fault::kNone:
      return "";
    case exchange::Fault::kEmergencyStop:
      return "An emergency stop was asked for. Make sure that the person is safe, then clear the fault.";
    case exchange::Fault::kDriveSilent:
      return "The drive did not answer for " + value + " ticks, of which " + limit +
             " can be bridged. Check its power and its cable, then clear the fault.";
    case exchange::Fault::kNotFinite:
      return "A reading or a computed value was no number (" + value +
             "). Check the encoder and its cable, then clear the fault.";
    case exchange::Fault::kPositionLimit:
      return "The position reached " + value + ", past its limit of " + limit +
             ". Move the device back inside, then clear the fault.";
    case exchange::Fault::kVelocityLimit:
      return "The velocity reached " + value + ", above its limit of " + limit +
             ". Let the device come to rest, then clear the fault.";
    case exchange::Fault::kOverrun:
      return "The loop missed " + value + " periods in a row, of which " + limit +
             " are allowed. Relieve the host or lengthen the period, then clear the fault.";
    case exchange::Fault::kDriveRefused:
      return "The drive could not be enabled. Check its power, its emergency circuit and its own fault "
             "display, "
             "then clear the fault.";
  }
  return "An unknown fault. Restart the server.";
}

}  // namespace mwidth::gate
