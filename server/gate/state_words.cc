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
  const std::string figures = " (" + Figure(fault.value) + ", limit " + Figure(fault.limit) + ")";
  switch (fault.fault) {
    case exchange::Fault::kNone:
      return "";
    case exchange::Fault::kEmergencyStop:
      return "An emergency stop was asked for. Make sure that the person is safe, then clear the fault.";
    case exchange::Fault::kDriveSilent:
      return "The drive did not answer" + figures + ". Check its power and its cable, then clear the fault.";
    case exchange::Fault::kNotFinite:
      return "A reading or a computed value was not plausible" + figures +
             ". Check the encoder and its cable, then clear the fault.";
    case exchange::Fault::kPositionLimit:
      return "The position left its range" + figures + ". Move the device back inside, then clear the fault.";
    case exchange::Fault::kVelocityLimit:
      return "The device moved too fast" + figures + ". Let it come to rest, then clear the fault.";
    case exchange::Fault::kOverrun:
      return "The loop missed too many periods in a row" + figures +
             ". Relieve the host or lengthen the period, then clear the fault.";
    case exchange::Fault::kDriveRefused:
      return "The drive could not be enabled. Check its power, its emergency circuit and its own fault "
             "display, "
             "then clear the fault.";
  }
  return "An unknown fault. Restart the server.";
}

}  // namespace mwidth::gate
