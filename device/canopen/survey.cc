#include "device/canopen/survey.h"

#include <cmath>
#include <cstdint>
#include <iomanip>
#include <optional>
#include <sstream>
#include <string>

#include "device/canopen/canopen_drive.h"
#include "device/canopen/cia402.h"
#include "device/canopen/objects.h"
#include "device/canopen/set_up.h"
#include "device/drive_lock.h"

namespace mwidth::device::canopen {
namespace {

/// What reading an object brought: the value, or why there is none.
struct Answer {
  std::optional<uint32_t> value;
  std::string failure;
};

Answer Read(SdoClient& sdo, const Object& object) {
  try {
    return {.value = sdo.Upload(object), .failure = {}};
  } catch (const std::runtime_error& error) {
    return {.value = {}, .failure = error.what()};
  }
}

SurveyFinding DeviceFinding(const Answer& type) {
  constexpr uint32_t kProfileBits = 0xFFFF;
  const uint32_t profile = *type.value & kProfileBits;
  std::ostringstream text;
  text << "profile " << profile << " (1000h)";
  return {"device", text.str(),
          profile == kDriveProfile ? "" : "That is no drive, which would be 402: check axis.drive.node."};
}

SurveyFinding StateFinding(SdoClient& sdo) {
  const Answer word = Read(sdo, kStatusword);
  if (!word.value) {
    return {"state", word.failure, "Check that it is a CiA 402 drive."};
  }
  const DriveState state = StateOf(static_cast<uint16_t>(*word.value));
  std::ostringstream text;
  text << NameOf(state);
  if (const Answer error = Read(sdo, kErrorCode); error.value && *error.value != 0) {
    text << ", error code " << std::hex << std::uppercase << *error.value << 'h';
  }
  const bool enabled = state == DriveState::kOperationEnabled;
  return {"state", text.str(),
          enabled ? "Something enabled the motor: end it before a server takes the drive." : ""};
}

SurveyFinding ModeFinding(SdoClient& sdo) {
  constexpr uint32_t kModeBit = 1U << (kCyclicSynchronousTorque - 1);
  const Answer modes = Read(sdo, kSupportedModes);
  const bool supported = modes.value && (*modes.value & kModeBit) != 0;
  return {"mode",
          supported     ? "cyclic synchronous torque is known (6502h)"
          : modes.value ? "cyclic synchronous torque is not known (6502h)"
                        : modes.failure,
          // 6502h need not be there: set-up tries the mode itself.
          supported || !modes.value ? "" : "Only a drive that has this mode can render."};
}

SurveyFinding PositionFinding(SdoClient& sdo, double scale, const char* unit) {
  const Answer position = Read(sdo, kPosition);
  if (!position.value) {
    return {"position", position.failure, "Check that the encoder is configured in the drive."};
  }
  const auto counts = static_cast<int32_t>(*position.value);
  std::ostringstream text;
  text << counts * scale << ' ' << unit << " (" << counts << " in 6064h)";
  return {"position", text.str(), ""};
}

SurveyFinding TorqueFinding(SdoClient& sdo, double configured, const char* unit) {
  const Answer rated = Read(sdo, kRatedTorque);
  if (!rated.value) {
    return {"rated torque", rated.failure, "Set 6076h with the drive's own tool."};
  }
  const double seen = *rated.value * 1e-3;
  std::ostringstream text;
  text << seen << ' ' << unit << " (" << *rated.value << " in 6076h)";
  return {"rated torque", text.str(),
          IsRatedTorque(*rated.value, configured)
              ? ""
              : "axis.drive.torque.rated differs: every force would be wrong by that."};
}

// A server sets both when it connects; what matters before is that the drive has them.
SurveyFinding WatchdogFinding(SdoClient& sdo, bool without) {
  const Answer consumer = Read(sdo, kConsumerHeartbeat);
  const Answer reaction = Read(sdo, kConnectionLossOption);
  if (consumer.value && reaction.value) {
    return {"watchdog", "heartbeats can be watched (1016h), with a reaction (6007h)", ""};
  }
  return {"watchdog", consumer.value ? reaction.failure : consumer.failure,
          without
              ? ""
              : "Without it the drive would hold its last force when the server dies: it is armed only with "
                "axis.drive.without_watchdog."};
}

}  // namespace

SurveyReport SurveyOn(can::Bus& bus, const CanopenDriveConfig& config, model::AxisKind kind, Now now) {
  SdoClient sdo(bus, config.node, now);
  const Answer type = Read(sdo, kDeviceType);
  if (!type.value) {
    return {{"device", type.failure, "Until it answers, nothing else is asked."}};
  }
  const bool rotary = kind == model::AxisKind::kRotary;
  return {DeviceFinding(type),
          StateFinding(sdo),
          ModeFinding(sdo),
          PositionFinding(sdo, config.position_scale, rotary ? "rad" : "m"),
          TorqueFinding(sdo, config.rated_torque, rotary ? "N m" : "N"),
          WatchdogFinding(sdo, config.without_watchdog)};
}

SurveyReport Survey(const CanopenDriveConfig& config, model::AxisKind kind) {
  const DriveLock lock(LockNameOf(config));
  const auto bus = can::MakeBus(config.bus);
  bus->Connect();
  return SurveyOn(*bus, config, kind, NowNs);
}

}  // namespace mwidth::device::canopen
