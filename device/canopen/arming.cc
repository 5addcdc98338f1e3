#include "device/canopen/arming.h"

#include <cmath>

#include "device/canopen/cia402.h"
#include "device/canopen/sdo.h"

namespace mwidth::device::canopen {
namespace {

constexpr int64_t kSdoPatienceNs = 250'000'000;

}  // namespace

Arming::Step Arming::End(Enabling enabling) noexcept {
  stage_ = Stage::kBegin;
  return {.enabling = enabling, .request = {}, .controlword = {}};
}

Arming::Step Arming::Ask(Stage stage, const Object& object, int64_t now_ns) noexcept {
  stage_ = stage;
  asked_ = object;
  asked_ns_ = now_ns;
  reply_ = {};
  return {.request = UploadRequest(config_.node, object), .controlword = {}};
}

void Arming::Hear(const can::Frame& reply) noexcept {
  if (stage_ == Stage::kAskTimeout || stage_ == Stage::kAskReaction) {
    const SdoReply judged = UploadReply(reply, asked_);
    reply_ = judged.kind == SdoKind::kOther ? reply_ : judged;
  }
}

// 1016h:1 watches our heartbeat, and not too patiently; 6007h does something.
bool Arming::Protects(uint32_t value) const noexcept {
  if (stage_ == Stage::kAskReaction) {
    return static_cast<uint16_t>(value) != static_cast<uint16_t>(ConnectionLoss::kNone);
  }
  constexpr uint32_t kNodeShift = 16;
  constexpr uint32_t kNodeBits = 0x7F;
  constexpr uint32_t kTimeBits = 0xFFFF;
  const uint32_t timeout_ms = value & kTimeBits;
  return (value >> kNodeShift & kNodeBits) == config_.own_node && timeout_ms > 0 &&
         timeout_ms * 1e-3 <= kMaxWatchdogS;
}

Arming::Step Arming::Await(int64_t now_ns) noexcept {
  switch (reply_.kind) {
    case SdoKind::kOther:
      return now_ns - asked_ns_ > kSdoPatienceNs ? End(Enabling::kSilent) : Step{};
    case SdoKind::kAborted:
    case SdoKind::kWrongSize:
      return End(Enabling::kNoWatchdog);
    case SdoKind::kValue:
    case SdoKind::kTaken:
      break;
  }
  if (!Protects(reply_.value)) {
    return End(Enabling::kNoWatchdog);
  }
  if (stage_ == Stage::kAskTimeout) {
    return Ask(Stage::kAskReaction, kConnectionLossOption, now_ns);
  }
  stage_ = Stage::kWalk;
  return {};
}

Arming::Step Arming::Walk(uint16_t statusword) noexcept {
  const DriveState state = StateOf(statusword);
  if (state == DriveState::kOperationEnabled && controlword_ == kEnableOperation) {
    return End(Enabling::kEnabled);
  }
  controlword_ = TowardsEnabled(state, controlword_);
  return {.request = {}, .controlword = controlword_};
}

Arming::Step Arming::Next(uint16_t statusword, int64_t now_ns) noexcept {
  switch (stage_) {
    case Stage::kBegin:
      controlword_ = kDisableVoltage;
      if (!config_.without_watchdog) {
        return Ask(Stage::kAskTimeout, kConsumerHeartbeat, now_ns);
      }
      stage_ = Stage::kWalk;
      return Walk(statusword);
    case Stage::kAskTimeout:
    case Stage::kAskReaction:
      return Await(now_ns);
    case Stage::kWalk:
      break;
  }
  return Walk(statusword);
}

}  // namespace mwidth::device::canopen
