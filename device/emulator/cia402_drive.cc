#include "device/emulator/cia402_drive.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mwidth::device::emulator {
namespace {

constexpr ObjectId kConnectionLoss{0x6007, 0};
constexpr ObjectId kErrorCode{0x603F, 0};
constexpr ObjectId kControlword{0x6040, 0};
constexpr ObjectId kStatusword{0x6041, 0};
constexpr ObjectId kQuickStopOption{0x605A, 0};
constexpr ObjectId kMode{0x6060, 0};
constexpr ObjectId kModeDisplay{0x6061, 0};
constexpr ObjectId kPosition{0x6064, 0};
constexpr ObjectId kTargetTorque{0x6071, 0};
constexpr ObjectId kMaxTorque{0x6072, 0};
constexpr ObjectId kRatedTorque{0x6076, 0};
constexpr ObjectId kTorque{0x6077, 0};
constexpr ObjectId kInterpolationPeriod{0x60C2, 1};
constexpr ObjectId kSupportedModes{0x6502, 0};

constexpr int64_t kNoMode = 0;
constexpr int64_t kCyclicSynchronousTorque = 10;

}  // namespace

Cia402Drive::Cia402Drive(const canopen::CanopenDriveConfig& config, ObjectDictionary& objects, Joint& joint)
    : objects_(objects),
      joint_(joint),
      position_sign_(config.position_scale < 0 ? -1 : 1),
      torque_sign_(config.torque_reversed ? -1 : 1) {
  AddControl();
  AddMotion(config);
}

void Cia402Drive::AddControl() {
  objects_.Add(
      kConnectionLoss,
      {.bytes = 2, .is_signed = true, .access = Access::kReadWrite, .initial = 1, .min = 0, .max = 3});
  objects_.Add(kErrorCode, {.bytes = 2, .mappable = true, .read = [this] { return error_code_; }});
  objects_.Add(kControlword,
               {.bytes = 2, .access = Access::kReadWrite, .mappable = true, .write = [this](int64_t word) {
                  power_.Command(static_cast<uint16_t>(word), now_ns_);
                  Follow();
                  return SdoAbort::kNone;
                }});
  objects_.Add(kStatusword, {.bytes = 2, .mappable = true, .read = [this] { return Statusword(); }});
  objects_.Add(kQuickStopOption, {.bytes = 2,
                                  .is_signed = true,
                                  .access = Access::kReadWrite,
                                  .initial = 2,
                                  .min = 0,
                                  .max = 3,
                                  .write = [this](int64_t option) {
                                    power_.SetQuickStopOption(static_cast<int16_t>(option));
                                    return SdoAbort::kNone;
                                  }});
  power_.SetQuickStopOption(2);
  objects_.Add(kMode, {.bytes = 1,
                       .is_signed = true,
                       .access = Access::kReadWrite,
                       .mappable = true,
                       .write = [this](int64_t mode) { return JudgeMode(mode); }});
  objects_.Add(kModeDisplay,
               {.bytes = 1, .is_signed = true, .mappable = true, .read = [this] { return mode_; }});
  // Bit 9: cyclic synchronous torque.
  objects_.Add(kSupportedModes, {.initial = 1 << (kCyclicSynchronousTorque - 1)});
}

void Cia402Drive::AddMotion(const canopen::CanopenDriveConfig& config) {
  objects_.Add(kPosition, {.is_signed = true, .mappable = true, .read = [this] {
                             return position_sign_ * joint_.PositionCounts(now_ns_);
                           }});
  objects_.Add(kTargetTorque, {.bytes = 2,
                               .is_signed = true,
                               .access = Access::kReadWrite,
                               .mappable = true,
                               .write = [this](int64_t torque) {
                                 target_torque_ = torque;
                                 Follow();
                                 return SdoAbort::kNone;
                               }});
  objects_.Add(kMaxTorque, {.bytes = 2,
                            .access = Access::kReadWrite,
                            .mappable = true,
                            .initial = 1000,
                            .max = std::numeric_limits<int16_t>::max()});
  objects_.Add(kRatedTorque, {.initial = std::llround(config.rated_torque * 1000)});
  objects_.Add(kTorque, {.bytes = 2, .is_signed = true, .mappable = true, .read = [this] {
                           return int64_t{torque_sign_} * joint_.force_counts();
                         }});
  objects_.Add({kInterpolationPeriod.index, 0}, {.bytes = 1, .initial = 2});
  objects_.Add(kInterpolationPeriod, {.bytes = 1, .access = Access::kReadWrite, .initial = 1, .min = 1});
  objects_.Add(
      {kInterpolationPeriod.index, 2},
      {.bytes = 1, .is_signed = true, .access = Access::kReadWrite, .initial = -3, .min = -6, .max = 0});
}

SdoAbort Cia402Drive::JudgeMode(int64_t mode) {
  if (mode != kNoMode && mode != kCyclicSynchronousTorque) {
    return SdoAbort::kInvalidValue;
  }
  mode_ = mode;
  Follow();
  return SdoAbort::kNone;
}

int64_t Cia402Drive::LimitedTorque() const {
  const int64_t most = objects_.Get(kMaxTorque);
  return std::clamp(target_torque_, -most, most);
}

int64_t Cia402Drive::Statusword() const {
  constexpr int64_t kRemote = 0x0200;
  constexpr int64_t kInternalLimit = 0x0800;
  // In this mode: that the drive follows the target.
  constexpr int64_t kFollows = 0x1000;
  int64_t word = power_.StatuswordBits() | kRemote;
  if (power_.state() == PowerState::kOperationEnabled && mode_ == kCyclicSynchronousTorque) {
    word |= kFollows | (LimitedTorque() == target_torque_ ? 0 : kInternalLimit);
  }
  return word;
}

void Cia402Drive::Follow() {
  const bool enabled = power_.state() == PowerState::kOperationEnabled;
  joint_.SetEnabled(now_ns_, enabled);
  if (enabled) {
    const int64_t torque = mode_ == kCyclicSynchronousTorque ? LimitedTorque() : 0;
    joint_.SetForce(now_ns_, static_cast<int32_t>(torque_sign_ * torque));
  }
}

void Cia402Drive::Turn(int64_t now_ns) {
  now_ns_ = now_ns;
  const PowerState before = power_.state();
  power_.Turn(now_ns);
  if (power_.state() != before) {
    if (before == PowerState::kFault) {
      error_code_ = 0;
    }
    Follow();
  }
}

void Cia402Drive::Fail(uint16_t code) {
  error_code_ = code;
  power_.Fail();
  Follow();
}

void Cia402Drive::LoseConnection(int64_t now_ns, double after_s, uint16_t code) {
  const auto option = static_cast<ConnectionLossOption>(objects_.Get(kConnectionLoss));
  if (power_.state() != PowerState::kOperationEnabled || option == ConnectionLossOption::kNone) {
    return;
  }
  joint_.Trip(now_ns, after_s);
  if (option == ConnectionLossOption::kFault) {
    Fail(code);
  } else if (option == ConnectionLossOption::kDisableVoltage) {
    power_.DisableVoltage();
  } else {
    power_.QuickStop(now_ns);
  }
  Follow();
}

void Cia402Drive::Reset() {
  constexpr uint16_t kFirst = 0x6000;
  constexpr uint16_t kLast = 0x9FFF;
  objects_.Reset(kFirst, kLast);
  power_.Reset();
  power_.SetQuickStopOption(static_cast<int16_t>(objects_.Get(kQuickStopOption)));
  error_code_ = 0;
  mode_ = kNoMode;
  target_torque_ = 0;
  Follow();
}

}  // namespace mwidth::device::emulator
