#include "device/canopen/process_data.h"

#include <utility>

#include "device/canopen/frames.h"

namespace mwidth::device::canopen {
namespace {

// Frames that one tick takes from the bus before it goes on: a flood must not hold the loop.
constexpr int kMostDrained = 64;
// Ticks that only listen for an answer that is missing. The third tick without a position is a fault of the
// loop, which disables the drive; so no late position ever passes for a fresh one while there is a force.
constexpr int kListeningTicks = 2;

int64_t Nanoseconds(double time_s) noexcept { return static_cast<int64_t>(time_s * 1e9); }

}  // namespace

void ProcessData::Begin() noexcept {
  watch_.Begin(now_());
  sdo_answer_.reset();
  answered_ = false;
  silent_ticks_ = 0;
  unanswered_ = 0;
  listening_ticks_ = 0;
  sends_heartbeats_ = true;
  next_heartbeat_ns_ = 0;
}

void ProcessData::Heartbeat(int64_t now_ns) noexcept {
  if (sends_heartbeats_ && now_ns >= next_heartbeat_ns_) {
    bus_.Send(HeartbeatFrame(config_.own_node, NmtState::kOperational));
    next_heartbeat_ns_ = now_ns + Nanoseconds(config_.heartbeat_s);
  }
}

bool ProcessData::Command(uint16_t controlword, int32_t torque_per_mille) noexcept {
  return bus_.Send(CommandFrame(config_.node, {.controlword = controlword,
                                               .torque_per_mille = static_cast<int16_t>(torque_per_mille)}));
}

void ProcessData::Sync() noexcept { unanswered_ += bus_.Send(SyncFrame()) ? 1 : 0; }

std::optional<can::Frame> ProcessData::TakeSdoAnswer() noexcept {
  return std::exchange(sdo_answer_, std::nullopt);
}

void ProcessData::Hear(const can::Frame& frame) noexcept {
  switch (watch_.Hear(frame, now_())) {
    case Heard::kFeedback:
      answered_ = unanswered_ == 1;
      watch_.counters.late_positions += answered_ ? 0 : 1;
      unanswered_ -= unanswered_ > 0 ? 1 : 0;
      break;
    case Heard::kSdoAnswer:
      sdo_answer_ = frame;
      break;
    case Heard::kNoted:
      break;
  }
}

bool ProcessData::Drain() noexcept {
  can::Frame frame;
  can::Reception reception = can::Reception::kFrame;
  for (int drained = 0; drained < kMostDrained && reception == can::Reception::kFrame; ++drained) {
    reception = bus_.Receive(frame, 0);
    if (reception == can::Reception::kFrame) {
      Hear(frame);
    }
  }
  return reception != can::Reception::kLost;
}

bool ProcessData::AwaitAnswers(int64_t deadline_ns) noexcept {
  can::Frame frame;
  can::Reception reception = can::Reception::kFrame;
  while (unanswered_ > 0 && reception == can::Reception::kFrame) {
    reception = bus_.Receive(frame, deadline_ns);
    if (reception == can::Reception::kFrame) {
      Hear(frame);
      if (now_() >= deadline_ns) {
        break;
      }
    }
  }
  return reception != can::Reception::kLost;
}

bool ProcessData::Ask(int64_t deadline_ns) noexcept {
  answered_ = false;
  if (!Drain() || !AwaitAnswers(deadline_ns)) {
    return false;
  }
  // What came so far was asked for by an earlier tick.
  watch_.counters.late_positions += std::exchange(answered_, false) ? 1 : 0;
  if (unanswered_ > 0) {
    if (++listening_ticks_ == kListeningTicks) {
      unanswered_ = listening_ticks_ = 0;  // It is lost: the next tick asks anew.
    }
    return true;
  }
  listening_ticks_ = 0;
  Sync();
  return AwaitAnswers(deadline_ns);
}

bool ProcessData::Exchange() noexcept {
  const int64_t begin_ns = now_();
  Heartbeat(begin_ns);
  const bool joined = Ask(begin_ns + Nanoseconds(config_.reply_deadline_s));
  answered_ = answered_ && joined;
  silent_ticks_ = answered_ ? 0 : silent_ticks_ + 1;
  return joined;
}

}  // namespace mwidth::device::canopen
