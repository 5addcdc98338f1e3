#include "device/emulator/canopen_node.h"

#include <algorithm>
#include <utility>

#include "device/emulator/sdo_server.h"

namespace mwidth::device::emulator {
namespace {

// Function codes of the predefined connection set (CiA 301, section 7.3.5), to which the node is added.
constexpr uint16_t kNmt = 0x000;
constexpr uint16_t kSync = 0x080;
constexpr uint16_t kEmergency = 0x080;
constexpr uint16_t kTpdo1 = 0x180;
constexpr uint16_t kRpdo1 = 0x200;
constexpr uint16_t kSdoAnswer = 0x580;
constexpr uint16_t kSdoRequest = 0x600;
constexpr uint16_t kHeartbeat = 0x700;
constexpr uint16_t kNodeBits = 0x7F;

constexpr ObjectId kErrorRegister{0x1001, 0};
constexpr ObjectId kHeartbeatTime{0x1017, 0};
constexpr int64_t kNsPerMs = 1'000'000;

// A device profile of 402 with a servo drive (CiA 402-2, object 1000h).
constexpr int64_t kServoDrive = 0x0002'0192;

constexpr uint16_t kCommunicationError = 0x8100;
constexpr uint16_t kHeartbeatError = 0x8130;
constexpr uint16_t kPdoLengthError = 0x8210;

}  // namespace

CanopenNode::CanopenNode(const canopen::CanopenDriveConfig& config, bool has_watchdog, Joint& joint,
                         const LinkFaults& faults, std::function<void(const can::Frame&)> send)
    : node_(config.node),
      faults_(faults),
      send_(std::move(send)),
      drive_(config, objects_, joint),
      rpdo_(objects_, {.direction = PdoDirection::kReceive,
                       .index = 0x1400,
                       .identifier = static_cast<uint16_t>(kRpdo1 + config.node),
                       .type = 255,
                       .mapping = {0x6040'0010}}),
      tpdo_(objects_, {.direction = PdoDirection::kTransmit,
                       .index = 0x1800,
                       .identifier = static_cast<uint16_t>(kTpdo1 + config.node),
                       .mapping = {0x6041'0010}}) {
  AddObjects();
  if (has_watchdog) {
    watch_.emplace(objects_);
  }
}

void CanopenNode::AddObjects() {
  objects_.Add({0x1000, 0}, {.initial = kServoDrive});
  objects_.Add(kErrorRegister, {.bytes = 1, .mappable = true, .read = [this] { return ErrorRegister(); }});
  objects_.Add({0x1005, 0}, {.initial = kSync});
  objects_.Add({0x1014, 0}, {.initial = kEmergency + node_});
  objects_.Add(kHeartbeatTime, {.bytes = 2, .access = Access::kReadWrite, .write = [this](int64_t) {
                                  heart_beats_ns_ = 0;
                                  return SdoAbort::kNone;
                                }});
  objects_.Add({0x1018, 0}, {.bytes = 1, .initial = 1});
  // No vendor has 0.
  objects_.Add({0x1018, 1}, {});
}

void CanopenNode::SendTo(uint16_t function, std::span<const uint8_t> bytes) {
  can::Frame frame{.identifier = static_cast<uint16_t>(function + node_),
                   .size = static_cast<uint8_t>(bytes.size())};
  std::copy(bytes.begin(), bytes.end(), frame.bytes.begin());
  send_(frame);
}

void CanopenNode::Receive(const can::Frame& frame, int64_t now_ns) {
  Turn(now_ns);
  if (frame.remote || state_ == State::kBooting) {
    return;
  }
  if (frame.identifier == kNmt && frame.size == 2 && (frame.bytes[1] == 0 || frame.bytes[1] == node_)) {
    ObeyNmt(frame.bytes[0], now_ns);
  } else if ((frame.identifier & ~kNodeBits) == kHeartbeat && frame.size == 1) {
    if (watch_ && watch_->Hear(static_cast<uint8_t>(frame.identifier & kNodeBits), now_ns)) {
      // It is back, until it is missed again.
      master_lost_ = false;
    }
  } else if (state_ == State::kStopped) {
    return;
  } else if (frame.identifier == kSdoRequest + node_) {
    AnswerSdoRequest(frame);
  } else if (state_ == State::kOperational && frame.identifier == kSync) {
    Sync();
  } else if (state_ == State::kOperational && rpdo_.valid() && frame.identifier == rpdo_.identifier()) {
    TakeRpdo(frame);
  }
  TellError();
}

void CanopenNode::AnswerSdoRequest(const can::Frame& frame) {
  if (const auto answer = AnswerSdo(frame.data(), objects_, faults_.exceptions)) {
    SendTo(kSdoAnswer, *answer);
  }
}

void CanopenNode::TakeRpdo(const can::Frame& frame) {
  if (rpdo_.synchronous()) {
    waiting_ = frame;
  } else {
    short_pdo_ = !rpdo_.Unpack(frame);
  }
}

void CanopenNode::Sync() {
  if (const auto frame = std::exchange(waiting_, std::nullopt)) {
    short_pdo_ = !rpdo_.Unpack(*frame);
  }
  if (tpdo_.valid() && ++syncs_ >= tpdo_.type()) {
    syncs_ = 0;
    send_(tpdo_.Pack(faults_.wrong_order));
  }
}

void CanopenNode::ObeyNmt(uint8_t command, int64_t now_ns) {
  constexpr uint16_t kFirstCommunication = 0x1000;
  constexpr uint16_t kLastCommunication = 0x1FFF;
  switch (command) {
    case 0x01:
      state_ = State::kOperational;
      syncs_ = 0;
      break;
    case 0x02:
      state_ = State::kStopped;
      drive_.LoseConnection(now_ns, 0, kCommunicationError);
      break;
    case 0x80:
      state_ = State::kPreOperational;
      break;
    case 0x81:
      drive_.Reset();
      [[fallthrough]];
    case 0x82:
      drive_.LoseConnection(now_ns, 0, kCommunicationError);
      objects_.Reset(kFirstCommunication, kLastCommunication);
      Boot(now_ns);
      break;
    default:
      break;
  }
}

void CanopenNode::Boot(int64_t now_ns) {
  state_ = State::kBooting;
  boots_ns_ = now_ns + kBootNs;
  heart_beats_ns_ = 0;
  master_lost_ = false;
  short_pdo_ = false;
  told_error_ = 0;
  waiting_.reset();
  if (watch_) {
    watch_->Reset();
  }
}

void CanopenNode::Turn(int64_t now_ns) {
  drive_.Turn(now_ns);
  if (state_ == State::kBooting) {
    if (boots_ns_ == 0) {
      boots_ns_ = now_ns + kBootNs;
    }
    if (now_ns < boots_ns_) {
      return;
    }
    constexpr std::array<uint8_t, 1> kBootUp{0};
    SendTo(kHeartbeat, kBootUp);
    state_ = State::kPreOperational;
  }
  if (watch_) {
    if (const auto missed_ns = watch_->Missed(now_ns)) {
      LoseMaster(*missed_ns);
    }
  }
  BeatHeart(now_ns);
  TellError();
}

void CanopenNode::LoseMaster(int64_t missed_ns) {
  master_lost_ = true;
  drive_.LoseConnection(missed_ns, watch_->patience_s(), kHeartbeatError);
  // What 1029h says by default of a communication error.
  if (state_ == State::kOperational) {
    TellError();
    state_ = State::kPreOperational;
  }
}

void CanopenNode::BeatHeart(int64_t now_ns) {
  const int64_t period_ns = objects_.Get(kHeartbeatTime) * kNsPerMs;
  if (period_ns == 0) {
    return;
  }
  if (heart_beats_ns_ == 0) {
    heart_beats_ns_ = now_ns + period_ns;
  }
  if (now_ns < heart_beats_ns_) {
    return;
  }
  // Kept to its grid, but never made up for.
  heart_beats_ns_ = std::max(heart_beats_ns_ + period_ns, now_ns);
  constexpr std::array<uint8_t, 4> kCodes{0x00, 0x04, 0x7F, 0x05};
  const std::array<uint8_t, 1> state{kCodes.at(static_cast<std::size_t>(state_))};
  if (!faults_.heartbeat_lost) {
    SendTo(kHeartbeat, state);
  }
}

void CanopenNode::Fail(uint16_t code, int64_t now_ns) {
  drive_.Turn(now_ns);
  drive_.Fail(code);
  TellError();
}

uint16_t CanopenNode::ErrorCode() const {
  if (drive_.error_code() != 0) {
    return drive_.error_code();
  }
  if (master_lost_) {
    return kHeartbeatError;
  }
  return short_pdo_ ? kPdoLengthError : 0;
}

uint8_t CanopenNode::ErrorRegister() const {
  constexpr uint8_t kGeneric = 0x01;
  constexpr uint8_t kCommunication = 0x10;
  const uint16_t code = ErrorCode();
  if (code == 0) {
    return 0;
  }
  return code >> 12 == 8 ? kGeneric | kCommunication : kGeneric;
}

// Neither while it starts nor while it is stopped: then it tells later (CiA 301, table 38).
void CanopenNode::TellError() {
  const uint16_t code = ErrorCode();
  if (code == told_error_ || state_ == State::kBooting || state_ == State::kStopped) {
    return;
  }
  told_error_ = code;
  constexpr std::size_t kEmergencyBytes = 8;
  std::vector<uint8_t> bytes = ToBytes(code, 2);
  bytes.push_back(ErrorRegister());
  bytes.resize(kEmergencyBytes);
  SendTo(kEmergency, bytes);
}

}  // namespace mwidth::device::emulator
