#include "device/canopen/canopen_drive.h"

#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <utility>

#include "device/canopen/cia402.h"
#include "device/canopen/frames.h"
#include "device/canopen/set_up.h"

namespace mwidth::device::canopen {
namespace {

// Ticks without a position that arming bears: an answer that is lost costs three.
constexpr uint64_t kArmingSilence = 5;
// How long a foreign frame keeps the drive from being armed: longer than another master's heartbeat takes.
constexpr int64_t kForeignMemoryNs = 2'000'000'000;

}  // namespace

std::string LockNameOf(const CanopenDriveConfig& config) {
  return "canopen:" + can::NameOf(config.bus) + " node " + std::to_string(config.node);
}

CanopenDrive::CanopenDrive(const CanopenDriveConfig& config)
    : CanopenDrive(config, can::MakeBus(config.bus), NowNs) {}

CanopenDrive::CanopenDrive(const CanopenDriveConfig& config, std::unique_ptr<can::Bus> bus, Now now)
    : lock_(LockNameOf(config)), config_(config), now_(now), bus_(std::move(bus)) {
  Connect();
}

CanopenDrive::~CanopenDrive() {
  reconnection_.Stop();
  Disable();
}

void CanopenDrive::Connect() {
  bus_->Connect();
  SetUp(*bus_, config_, now_);
  data_.Begin();
  arming_.Reset();
}

DriveInfo CanopenDrive::Info() const noexcept {
  constexpr int kPositionBits = 32;
  return {.position_quantum = std::abs(config_.position_scale),
          .force_quantum = config_.ForceQuantum(),
          .simulated = false,
          .position_bits = kPositionBits};
}

bool CanopenDrive::IsGone() const noexcept {
  const auto patience_ns = static_cast<int64_t>(kMostHeartbeatsMissing * config_.drive_heartbeat_s * 1e9);
  return !data_.watch().operational() || now_() - data_.watch().heartbeat_ns() > patience_ns;
}

void CanopenDrive::HandOver() noexcept {
  Disable();
  reconnection_.Lose();
}

bool CanopenDrive::HeardForeign(int64_t since_ns) const noexcept {
  const auto heard_ns = data_.watch().foreign_ns();
  return heard_ns && *heard_ns >= since_ns;
}

// A drive that has left "operation enabled" by itself makes no force any more, whatever it is told.
Reading CanopenDrive::WithTrouble(Reading reading) const noexcept {
  const NodeWatch& watch = data_.watch();
  if (!enabled_) {
    return reading;
  }
  if (watch.emergency_code() != 0 || StateOf(watch.feedback().statusword) != DriveState::kOperationEnabled) {
    reading.trouble = DriveTrouble::kError;
    reading.trouble_code = watch.emergency_code();
  } else if (HeardForeign(enabled_ns_)) {
    reading.trouble = DriveTrouble::kForeignTraffic;
    reading.trouble_code = watch.foreign_identifier();
  }
  return reading;
}

Reading CanopenDrive::Read(uint64_t /*tick*/) noexcept {
  if (!reconnection_.HasLink()) {
    return {};
  }
  const bool joined = data_.Exchange();
  WatchRelease();
  const int64_t raw = data_.watch().feedback().position;
  Reading reading =
      WithTrouble({.ok = data_.answered(), .position_counts = config_.position_scale < 0 ? -raw : raw});
  if (!joined || IsGone()) {
    reading.ok = false;
    HandOver();
  }
  return reading;
}

// A frame can be lost, and a drive can be deaf to it while it still hears SYNC. What makes it let go then is
// its own watchdog, which our heartbeat would keep quiet.
void CanopenDrive::WatchRelease() noexcept {
  if (enabled_ || arming_.under_way()) {
    data_.SendHeartbeats(true);
    return;
  }
  if (data_.answered()) {
    released_ = MakesNoForce(StateOf(data_.watch().feedback().statusword));
  }
  data_.SendHeartbeats(released_);
  if (!released_) {
    data_.Command(kDisableVoltage, 0);
  }
}

bool CanopenDrive::Write(int32_t force_counts) noexcept {
  if (!reconnection_.HasLink() || !enabled_ ||
      std::abs(int64_t{force_counts}) > config_.max_torque_per_mille) {
    return false;
  }
  // F_a acts against the positive direction (eq. 1), the drive's torque towards it.
  return data_.Command(kEnableOperation, config_.torque_reversed ? force_counts : -force_counts);
}

Enabling CanopenDrive::Enable() noexcept {
  if (!reconnection_.HasLink()) {
    return Enabling::kSilent;
  }
  const int64_t now_ns = now_();
  if (HeardForeign(now_ns - kForeignMemoryNs)) {
    return Enabling::kForeignTraffic;
  }
  if (!data_.answered()) {
    return data_.silent_ticks() <= kArmingSilence ? Enabling::kPending : Enabling::kSilent;
  }
  if (const auto reply = data_.TakeSdoAnswer()) {
    arming_.Hear(*reply);
  }
  const Arming::Step step = arming_.Next(data_.watch().feedback().statusword, now_ns);
  if (step.request) {
    data_.Send(*step.request);
  }
  if (step.controlword) {
    data_.Command(*step.controlword, 0);
  }
  if (step.enabling == Enabling::kEnabled) {
    enabled_ = true;
    enabled_ns_ = now_ns;
    data_.watch().ForgetEmergency();
  }
  return step.enabling;
}

void CanopenDrive::Disable() noexcept {
  enabled_ = false;
  if (!reconnection_.HasLink()) {
    return;
  }
  released_ = false;
  arming_.Reset();
  data_.Command(kDisableVoltage, 0);
  // A synchronous RPDO would wait for a SYNC that may never come.
  if (config_.exchange == TickExchange::kOnSync) {
    data_.Sync();
  }
}

}  // namespace mwidth::device::canopen
