#include "server/gate/state_words.h"

#include <cstdint>
#include <sstream>

#include "server/gate/figures.h"

namespace mwidth::gate {
namespace {

// Hexadecimal, as manuals print it: " (code FF10h)"; nothing for 0.
std::string CodeIn(const char* intro, double code) {
  if (code == 0) {
    return {};
  }
  std::ostringstream text;
  text << intro << std::hex << std::uppercase << static_cast<uint64_t>(code) << "h)";
  return text.str();
}

}  // namespace

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
             "display, then clear the fault.";
    case exchange::Fault::kNoDriveWatchdog:
      return "The drive has no watchdog that takes the force away within 0.1 s when nobody speaks to it: set "
             "its "
             "communication time-out and a reaction to it, or configure without_watchdog, then clear the "
             "fault.";
    case exchange::Fault::kForeignTraffic:
      return "Somebody else on the bus sends what only this server may send to the drive" +
             CodeIn(" (identifier ", fault.value) +
             ". Disconnect the other master, or give each node a number of its own, then clear the fault.";
    case exchange::Fault::kDriveError:
      return "The drive stopped following or reported an error" + CodeIn(" (code ", fault.value) +
             ". Look the code up in its manual, remove the cause, then clear the fault.";
    case exchange::Fault::kForceSaturation:
      return "The force was cut at its limit for " + value + " s of the watched window, of which " + limit +
             " s are allowed: the loop was not the one that was certified. Ask for a smaller mass or slower "
             "motion, or raise the force limit, then clear the fault.";
    case exchange::Fault::kForceSlew:
      return "The force was to change faster than its limit for " + value +
             " s of the watched window, of which " + limit +
             " s are allowed: the loop was not the one that was certified. Ask for a smaller mass or a lower "
             "cut-off frequency, or raise force_slew, then clear the fault.";
    case exchange::Fault::kEncoderJump:
      return "The encoder jumped: its counts demand an acceleration of at least " + value + ", above " +
             limit + ". Check the encoder, its cable and its coupling, then clear the fault.";
    case exchange::Fault::kEncoderFreeze:
      return "The encoder froze: its counts stopped dead from a velocity of " + value +
             ", where nothing above " + limit +
             " can, and have not changed since. Move the device by hand and check that its position follows, "
             "then clear the fault.";
    case exchange::Fault::kAccelerometer:
      return "The accelerometer is not to be believed: it told an acceleration that no joint has, or what it "
             "sums up to and the velocity of the encoder went apart, by " +
             value + ", where " + limit +
             " is the limit. Check the accelerometer's mounting, its cable and its sign, and the encoder, "
             "then clear the fault.";
    case exchange::Fault::kRepeatedOverrun:
      return "In " + value + " ticks in a row the loop missed a deadline, of which " + limit +
             " are allowed. Relieve the host or lengthen the period, then clear the fault.";
    case exchange::Fault::kLoopDelay:
      return "Again and again the force came too late after its position, at last by " + value +
             " s, where the stability of the loop is certified for " + limit +
             " s. Relieve the host or the drive's link, or certify the loop with a longer delay_s, then "
             "clear "
             "the fault.";
    case exchange::Fault::kPositionGaps:
      return "Positions or forces were missing for " + value + " s of the watched window, of which " + limit +
             " s are allowed. Check the drive's cable and the load of the host, then clear the fault.";
    case exchange::Fault::kGrowingOscillation:
      return "An oscillation grew by a factor of " + value + " in one period, where " + limit +
             " is the limit: the hand is not one that the mass is certified for. Ask for a smaller mass, or "
             "certify an envelope with less damping, then clear the fault.";
    case exchange::Fault::kEnergyExcess:
      return "The rendered force put in as much energy as a damping of " + value + " takes out, where " +
             limit +
             " is the limit: the hand is not one that the mass is certified for. Ask for a smaller mass, or "
             "certify an envelope with stiffer hands, then clear the fault.";
  }
  return "An unknown fault. Restart the server.";
}

}  // namespace mwidth::gate
