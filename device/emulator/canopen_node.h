// A CANopen node (CiA 301) with a drive (CiA 402).
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>

#include "device/can/frame.h"
#include "device/canopen/canopen_drive_config.h"
#include "device/emulator/cia402_drive.h"
#include "device/emulator/faults.h"
#include "device/emulator/heartbeat_watch.h"
#include "device/emulator/joint.h"
#include "device/emulator/object_dictionary.h"
#include "device/emulator/pdo.h"

namespace mwidth::device::emulator {

/// Answers NMT, SDO, SYNC and RPDO1; sends TPDO1, heartbeats and EMCY. Lives in one thread, and knows no time
/// but the one that it is told.
class CanopenNode {
 public:
  /// What a start takes, from a reset to the boot-up message.
  static constexpr int64_t kBootNs = 10'000'000;

  /// `has_watchdog`: whether it can watch its master's heartbeat. `send` puts a frame on the bus. References
  /// outlive it.
  CanopenNode(const canopen::CanopenDriveConfig& config, bool has_watchdog, Joint& joint,
              const LinkFaults& faults, std::function<void(const can::Frame&)> send);

  /// A frame of the bus.
  void Receive(const can::Frame& frame, int64_t now_ns);
  /// Lets time pass. To be called every millisecond.
  void Turn(int64_t now_ns);
  /// An error of its own: FAULT, and an EMCY.
  void Fail(uint16_t code, int64_t now_ns);

 private:
  enum class State : uint8_t { kBooting, kStopped, kPreOperational, kOperational };

  void AddObjects();
  void ObeyNmt(uint8_t command, int64_t now_ns);
  void Boot(int64_t now_ns);
  void AnswerSdoRequest(const can::Frame& frame);
  void TakeRpdo(const can::Frame& frame);
  void Sync();
  void LoseMaster(int64_t missed_ns);
  /// Says what is wrong where that has changed.
  void TellError();
  /// Bits of the error register (1001h) for what is wrong.
  uint8_t ErrorRegister() const;
  uint16_t ErrorCode() const;
  void SendTo(uint16_t function, std::span<const uint8_t> bytes);
  void BeatHeart(int64_t now_ns);

  const uint8_t node_;
  const LinkFaults& faults_;
  const std::function<void(const can::Frame&)> send_;
  ObjectDictionary objects_;
  Cia402Drive drive_;
  Pdo rpdo_;
  Pdo tpdo_;
  std::optional<HeartbeatWatch> watch_;

  State state_ = State::kBooting;
  int64_t boots_ns_ = 0;
  int64_t heart_beats_ns_ = 0;
  bool master_lost_ = false;
  bool short_pdo_ = false;
  uint16_t told_error_ = 0;
  uint8_t syncs_ = 0;
  /// What the next SYNC makes act.
  std::optional<can::Frame> waiting_;
};

}  // namespace mwidth::device::emulator
