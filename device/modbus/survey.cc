#include "device/modbus/survey.h"

#include <array>
#include <cmath>
#include <optional>
#include <sstream>
#include <string>

#include "device/drive.h"
#include "device/drive_lock.h"
#include "device/modbus/link.h"
#include "device/monotonic_clock.h"

namespace mwidth::device::modbus {
namespace {

// Nobody holds the joint by this drive yet: it has its time.
constexpr int64_t kPatienceNs = 500'000'000;

using Words = std::array<uint16_t, kMaxValueRegisters>;

/// What reading a value brought: the raw number, or why there is none.
struct Answer {
  std::optional<double> raw;
  std::string failure;
};

std::string FailureOf(Outcome outcome) {
  switch (outcome) {
    case Outcome::kException:
      return "the drive answers with an exception";
    case Outcome::kMalformed:
      return "the drive answers something that is no reply";
    case Outcome::kDisconnected:
      return "the connection was lost";
    case Outcome::kAnswered:
    case Outcome::kSilent:
      break;
  }
  return "no answer";
}

Answer ReadRaw(Link& link, const RegisterValue& value) {
  Words words{};
  const Request request = ReadRegisters(value.address, value.Registers());
  Outcome outcome = link.Exchange(request, words, NowNs() + kPatienceNs);
  if (outcome == Outcome::kSilent) {
    // A serial line only falls silent in the exchange after one that failed.
    outcome = link.Exchange(request, words, NowNs() + kPatienceNs);
  }
  if (outcome != Outcome::kAnswered) {
    return {.raw = {}, .failure = FailureOf(outcome) + " at register " + std::to_string(value.address)};
  }
  return {.raw = Decode(value, words), .failure = {}};
}

std::string Quantity(const RegisterValue& value, double raw, const char* unit) {
  std::ostringstream text;
  text << raw * value.scale + value.offset << ' ' << unit << " (" << raw << " in the register)";
  return text.str();
}

SurveyFinding SurveyValue(Link& link, const std::string& subject, const RegisterValue& value,
                          const char* unit) {
  const Answer answer = ReadRaw(link, value);
  if (!answer.raw) {
    return {subject, answer.failure,
            "Check unit, address and type of axis.drive." + subject + " in the drive's manual."};
  }
  SurveyFinding finding{subject, Quantity(value, *answer.raw, unit), ""};
  if (!std::isfinite(*answer.raw)) {
    finding.advice = "That is no number: check type and order of axis.drive." + subject + ".";
  }
  return finding;
}

SurveyFinding SurveyState(Link& link, const EnableRegister& enable) {
  const Answer answer = ReadRaw(link, {.address = enable.address, .type = RegisterType::kUint16});
  if (!answer.raw) {
    return {"state", answer.failure, "Check axis.drive.enable in the drive's manual."};
  }
  if (*answer.raw == enable.enabled) {
    return {"state", "enabled", "Something enabled the motor: end it before a server takes the drive."};
  }
  std::ostringstream text;
  text << (*answer.raw == enable.disabled ? "disabled" : "neither the word for enabled nor for disabled")
       << " (" << *answer.raw << " in the register)";
  return {"state", text.str(), ""};
}

SurveyFinding SurveyWatchdog(Link& link, const ModbusDriveConfig& config) {
  constexpr const char* kAdvice =
      "Set the drive's communication time-out to at most 0.1 s with a reaction that takes the force away, "
      "and "
      "name both registers in axis.drive.watchdog.";
  const std::string advice = config.without_watchdog ? "" : kAdvice;
  if (!config.map.watchdog) {
    return {"watchdog", "not configured", advice};
  }
  const Answer timeout = ReadRaw(link, config.map.watchdog->timeout);
  const Answer reaction =
      ReadRaw(link, {.address = config.map.watchdog->reaction, .type = RegisterType::kUint16});
  if (!timeout.raw || !reaction.raw) {
    return {"watchdog", timeout.raw ? reaction.failure : timeout.failure, advice};
  }
  const RegisterValue& value = config.map.watchdog->timeout;
  const double timeout_s = *timeout.raw * value.scale + value.offset;
  const bool reacts = *reaction.raw != config.map.watchdog->no_reaction;
  std::ostringstream text;
  text << "after " << timeout_s << " s, " << (reacts ? "with a reaction" : "without a reaction") << " ("
       << *reaction.raw << " in the register)";
  const bool proven = reacts && timeout_s > 0 && timeout_s <= kMaxWatchdogS;
  return {"watchdog", text.str(), proven ? "" : advice};
}

}  // namespace

SurveyReport Survey(const ModbusDriveConfig& config, model::AxisKind kind) {
  const DriveLock lock(LockNameOf(config.link));
  Link link(config.link);
  link.Connect();
  const bool rotary = kind == model::AxisKind::kRotary;
  SurveyReport report;
  if (config.map.enable) {
    report.push_back(SurveyState(link, *config.map.enable));
  }
  report.push_back(SurveyValue(link, "position", config.map.position, rotary ? "rad" : "m"));
  report.push_back(SurveyValue(link, "force", config.map.force, rotary ? "N m" : "N"));
  report.push_back(SurveyWatchdog(link, config));
  return report;
}

}  // namespace mwidth::device::modbus
