#include "device/emulator/heartbeat_watch.h"

namespace mwidth::device::emulator {
namespace {

constexpr ObjectId kConsumerCount{0x1016, 0};
constexpr ObjectId kConsumer{0x1016, 1};
constexpr int64_t kNsPerMs = 1'000'000;

int64_t PatienceMs(int64_t consumer) { return consumer & 0xFFFF; }
int64_t NodeOf(int64_t consumer) { return consumer >> 16 & 0xFF; }

}  // namespace

HeartbeatWatch::HeartbeatWatch(ObjectDictionary& objects) : objects_(objects) {
  objects_.Add(kConsumerCount, {.bytes = 1, .initial = 1});
  objects_.Add(kConsumer, {.access = Access::kReadWrite, .max = 0x7F'FFFF, .write = [this](int64_t) {
                             Reset();
                             return SdoAbort::kNone;
                           }});
}

double HeartbeatWatch::patience_s() const {
  return static_cast<double>(PatienceMs(objects_.Get(kConsumer))) / 1e3;
}

bool HeartbeatWatch::Hear(uint8_t node, int64_t now_ns) {
  const int64_t consumer = objects_.Get(kConsumer);
  const bool watched = node != 0 && node == NodeOf(consumer) && PatienceMs(consumer) != 0;
  if (watched) {
    heard_ns_ = now_ns;
  }
  return watched;
}

std::optional<int64_t> HeartbeatWatch::Missed(int64_t now_ns) {
  if (!heard_ns_) {
    return std::nullopt;
  }
  const int64_t end_ns = *heard_ns_ + PatienceMs(objects_.Get(kConsumer)) * kNsPerMs;
  if (now_ns <= end_ns) {
    return std::nullopt;
  }
  heard_ns_.reset();
  return end_ns;
}

}  // namespace mwidth::device::emulator
