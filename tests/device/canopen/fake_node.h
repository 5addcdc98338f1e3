// A CiA 402 drive on a bus of its own, in memory and in a time of its own, that does what a test says.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <utility>

#include "device/can/bus.h"
#include "device/canopen/canopen_drive_config.h"
#include "device/canopen/cia402.h"
#include "device/canopen/frames.h"
#include "device/canopen/little_endian.h"
#include "device/canopen/objects.h"

namespace mwidth::device::canopen::testing {

inline constexpr uint8_t kNode = 5;
inline constexpr uint8_t kOwnNode = 127;
inline constexpr int64_t kTickNs = 1'000'000;

inline std::atomic<int64_t> fake_now_ns{0};
inline int64_t FakeNow() noexcept { return fake_now_ns.load(); }

inline CanopenDriveConfig TestConfig() {
  return {.bus = can::SocketCan{.interface = "fake"},
          .node = kNode,
          .own_node = kOwnNode,
          .reply_deadline_s = 4e-4,
          .position_scale = 1e-4,
          .rated_torque = 0.25,
          .gear = 40,
          .max_torque_per_mille = 1500};
}

/// The drive. Not a model of its motor: the test says where it stands.
class FakeNode {
 public:
  FakeNode() {
    Set(kDeviceType, 0x0002'0000 | kDriveProfile);
    Set(kRatedTorque, 250);
    for (const Object& object :
         {kConsumerHeartbeat, kProducerHeartbeat, kRpdo1Identifier, kRpdo1Type, kRpdo1Count, kTpdo1Identifier,
          kTpdo1Type, kTpdo1Count, kConnectionLossOption, kControlword, kQuickStopOption, kModeOfOperation,
          kModeDisplay, kMaxTorque, kInterpolationPeriod, kInterpolationExponent}) {
      Set(object, 0);
    }
    for (uint8_t entry = 1; entry <= 3; ++entry) {
      Set({kRpdo1Mapping, entry, 4}, 0);
      Set({kTpdo1Mapping, entry, 4}, 0);
    }
  }

  void Set(const Object& object, uint32_t value) { objects[Key(object)] = {value, object.size}; }
  uint32_t Get(const Object& object) const { return objects.at(Key(object)).first; }
  /// From now on the object cannot be written, or read, but refused with this code.
  void Refuse(const Object& object, uint32_t abort_code) { aborts[Key(object)] = abort_code; }
  void Remove(const Object& object) {
    objects.erase(Key(object));
    Refuse(object, 0x0602'0000);
  }
  /// Something is on the bus after `delay_ns`.
  void Say(const can::Frame& frame, int64_t delay_ns = 0) { said.emplace(FakeNow() + delay_ns, frame); }
  void SayEmergency(uint16_t code) {
    can::Frame frame{.identifier = kEmergency + kNode, .size = 8};
    Put(frame, 0, 2, code);
    Say(frame);
  }
  void Fault(uint16_t code) {
    state = DriveState::kFault;
    SayEmergency(code);
  }
  void BootUp() {
    nmt = NmtState::kPreOperational;
    Say(HeartbeatFrame(kNode, NmtState::kBootUp));
  }
  /// What the motor does.
  int16_t Torque() const { return state == DriveState::kOperationEnabled ? torque : int16_t{0}; }

  /// A frame of the server.
  void Hear(const can::Frame& frame) {
    heard.push_back(frame);
    if (deaf) {
      return;
    }
    if (frame.identifier == kNmt) {
      HearNmt(static_cast<NmtCommand>(frame.bytes[0]));
    } else if (frame.identifier == kSync) {
      HearSync();
    } else if (frame.identifier == kRpdo1 + kNode) {
      commands.push_back(frame);
      if (!obeys) {
        return;
      }
      if (Get(kRpdo1Type) == kEventDriven) {
        Obey(frame);
      } else {
        waiting = frame;
      }
    } else if (frame.identifier == kSdoRequest + kNode) {
      HearSdo(frame);
    } else if (frame.identifier == kHeartbeat + kOwnNode) {
      ++heartbeats_heard;
    }
  }

  // What it is told by the test.
  int32_t position = 0;
  bool deaf = false;
  bool answers_sync = true;
  bool sends_heartbeats = true;
  bool fault_can_be_reset = true;
  bool boots = true;
  /// False: it hears SYNC, and no RPDO.
  bool obeys = true;
  int64_t answer_delay_ns = 100'000;
  uint8_t feedback_bytes = 8;
  /// Answers an SDO request in place of the drive.
  std::function<can::Frame(const can::Frame& request)> sdo_answer;

  // What it has come to.
  NmtState nmt = NmtState::kPreOperational;
  DriveState state = DriveState::kSwitchOnDisabled;
  int16_t torque = 0;
  uint16_t controlword = 0;
  int heartbeats_heard = 0;
  std::vector<can::Frame> heard;
  std::vector<can::Frame> commands;
  std::map<uint32_t, std::pair<uint32_t, uint8_t>> objects;
  std::map<uint32_t, uint32_t> aborts;
  std::multimap<int64_t, can::Frame> said;
  can::Frame waiting;
  int64_t heartbeat_ns = 0;

  static uint32_t Key(const Object& object) {
    return static_cast<uint32_t>(object.index) << 8 | object.subindex;
  }

 private:
  void HearNmt(NmtCommand command) {
    switch (command) {
      case NmtCommand::kStart:
        nmt = NmtState::kOperational;
        break;
      case NmtCommand::kStop:
        nmt = NmtState::kStopped;
        break;
      case NmtCommand::kEnterPreOperational:
        nmt = NmtState::kPreOperational;
        break;
      case NmtCommand::kResetNode:
      case NmtCommand::kResetCommunication:
        Set(kProducerHeartbeat, 0);
        Set(kConsumerHeartbeat, 0);
        if (boots) {
          BootUp();
        }
        break;
    }
  }
  uint16_t Statusword() const {
    switch (state) {
      case DriveState::kSwitchOnDisabled:
        return 0x250;
      case DriveState::kReadyToSwitchOn:
        return 0x231;
      case DriveState::kSwitchedOn:
        return 0x233;
      case DriveState::kOperationEnabled:
        return 0x1237;
      case DriveState::kQuickStopActive:
        return 0x217;
      default:
        return 0x218;
    }
  }
  void HearSync() {
    if (nmt != NmtState::kOperational) {
      return;
    }
    if (waiting.size > 0) {
      Obey(std::exchange(waiting, {}));
    }
    can::Frame frame{.identifier = kTpdo1 + kNode, .size = feedback_bytes};
    Put(frame, 0, 2, Statusword());
    Put(frame, 2, 4, static_cast<uint32_t>(position));
    Put(frame, 6, 2, static_cast<uint16_t>(Torque()));
    if (answers_sync) {
      Say(frame, answer_delay_ns);
    }
  }
  void Obey(const can::Frame& command) {
    const auto before = std::exchange(controlword, static_cast<uint16_t>(canopen::Get(command, 0, 2)));
    torque = static_cast<int16_t>(canopen::Get(command, 2, 2));
    if (state == DriveState::kFault) {
      const bool edge = (controlword & kFaultReset) != 0 && (before & kFaultReset) == 0;
      state = edge && fault_can_be_reset ? DriveState::kSwitchOnDisabled : state;
    } else if ((controlword & 0x02) == 0) {
      state = DriveState::kSwitchOnDisabled;
    } else if ((controlword & 0x0F) == kShutdown) {
      state = DriveState::kReadyToSwitchOn;
    } else if ((controlword & 0x0F) == kSwitchOn && state == DriveState::kReadyToSwitchOn) {
      state = DriveState::kSwitchedOn;
    } else if ((controlword & 0x0F) == kEnableOperation && state == DriveState::kSwitchedOn) {
      state = DriveState::kOperationEnabled;
    }
  }
  void HearSdo(const can::Frame& request) {
    constexpr int64_t kSdoDelayNs = 200'000;
    if (sdo_answer) {
      Say(sdo_answer(request), kSdoDelayNs);
      return;
    }
    const uint32_t key = canopen::Get(request, 1, 2) << 8 | request.bytes[3];
    can::Frame reply = request;
    reply.identifier = kSdoReply + kNode;
    Put(reply, 4, 4, 0);
    const bool download = (request.bytes[0] & 0xE0) == 0x20;
    const auto object = objects.find(key);
    const auto abort = aborts.find(key);
    if (abort != aborts.end() || object == objects.end()) {
      reply.bytes[0] = 0x80;
      Put(reply, 4, 4, abort != aborts.end() ? abort->second : 0x0602'0000);
    } else if (download) {
      const uint32_t value = canopen::Get(request, 4, object->second.second);
      object->second.first = value;
      if (key == Key(kModeOfOperation)) {
        Set(kModeDisplay, value);
      } else if (key == Key(kControlword)) {
        Obey(CommandFrame(kNode, {.controlword = static_cast<uint16_t>(value)}));
      }
      reply.bytes[0] = 0x60;
    } else {
      reply.bytes[0] = static_cast<uint8_t>(0x43 | (4 - object->second.second) << 2);
      Put(reply, 4, 4, object->second.first);
    }
    Say(reply, kSdoDelayNs);
  }
};

/// The bus between the server and the node. Waiting moves the time on.
class FakeBus final : public can::Bus {
 public:
  explicit FakeBus(std::shared_ptr<FakeNode> node) : node_(std::move(node)) {}

  void Connect() override {
    if (refuses) {
      throw std::runtime_error("no bus");
    }
    ++connects;
    lost = false;
    node_->said.clear();
  }
  bool Send(const can::Frame& frame) noexcept override {
    if (!lost) {
      node_->Hear(frame);
    }
    return !lost;
  }
  can::Reception Receive(can::Frame& frame, int64_t deadline_ns) noexcept override {
    if (lost) {
      return can::Reception::kLost;
    }
    const int64_t until_ns = std::max(deadline_ns, FakeNow());
    const int64_t heartbeat_ns = NextHeartbeatNs();
    const auto first = node_->said.begin();
    if (first != node_->said.end() && first->first <= std::min(until_ns, heartbeat_ns)) {
      fake_now_ns = std::max(FakeNow(), first->first);
      frame = first->second;
      node_->said.erase(first);
      return can::Reception::kFrame;
    }
    if (heartbeat_ns <= until_ns) {
      fake_now_ns = std::max(FakeNow(), heartbeat_ns);
      node_->heartbeat_ns = FakeNow();
      frame = HeartbeatFrame(kNode, node_->nmt);
      return can::Reception::kFrame;
    }
    fake_now_ns = until_ns;
    return can::Reception::kNothing;
  }
  const can::BusCounters& counters() const noexcept override { return counters_; }

  static inline std::atomic<bool> lost{false};
  static inline std::atomic<bool> refuses{false};
  static inline std::atomic<int> connects{0};

 private:
  int64_t NextHeartbeatNs() const {
    const int64_t period_ns = node_->Get(kProducerHeartbeat) * 1'000'000LL;
    const bool sends = period_ns > 0 && node_->sends_heartbeats && !node_->deaf;
    return sends ? node_->heartbeat_ns + period_ns : INT64_MAX;
  }

  std::shared_ptr<FakeNode> node_;
  can::BusCounters counters_;
};

}  // namespace mwidth::device::canopen::testing
