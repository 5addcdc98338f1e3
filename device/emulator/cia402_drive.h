// A drive's profile objects (CiA 402-2) in front of the joint: cyclic synchronous torque, and no other mode.
#pragma once

#include <cstdint>

#include "device/canopen/canopen_drive_config.h"
#include "device/emulator/joint.h"
#include "device/emulator/object_dictionary.h"
#include "device/emulator/power_state.h"

namespace mwidth::device::emulator {

/// What it does when whoever commands it is gone: values of 6007h.
enum class ConnectionLossOption : uint8_t { kNone = 0, kFault = 1, kDisableVoltage = 2, kQuickStop = 3 };

/// Torques are in thousandths of the rated torque, which is what the joint's force counts are. Lives in one
/// thread.
class Cia402Drive {
 public:
  /// Adds its objects to `objects`; all references outlive it.
  Cia402Drive(const canopen::CanopenDriveConfig& config, ObjectDictionary& objects, Joint& joint);

  /// Says what time it is, and takes the steps that are due.
  void Turn(int64_t now_ns);
  /// An error of the drive's own: FAULT, without torque, until a fault reset. `code` as in 603Fh.
  void Fail(uint16_t code);
  /// Does what 6007h says; where the motor loses its torque over that, it counts as the watchdog's doing, at
  /// `now_ns`, `after_s` after the last sign of life.
  void LoseConnection(int64_t now_ns, double after_s, uint16_t code);
  /// As after power-on.
  void Reset();
  /// 0 where there is no error.
  uint16_t error_code() const { return error_code_; }
  PowerState state() const { return power_.state(); }

 private:
  void AddControl();
  void AddMotion(const canopen::CanopenDriveConfig& config);
  /// Lets the joint follow the state and the target.
  void Follow();
  int64_t Statusword() const;
  int64_t LimitedTorque() const;
  SdoAbort JudgeMode(int64_t mode);

  ObjectDictionary& objects_;
  Joint& joint_;
  const int position_sign_;
  const int torque_sign_;
  PowerStateMachine power_;
  uint16_t error_code_ = 0;
  int64_t mode_ = 0;
  int64_t target_torque_ = 0;
  int64_t now_ns_ = 0;
};

}  // namespace mwidth::device::emulator
