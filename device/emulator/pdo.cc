#include "device/emulator/pdo.h"

#include <algorithm>
#include <span>

namespace mwidth::device::emulator {
namespace {

constexpr uint16_t kMappingOffset = 0x200;
constexpr uint8_t kMostObjects = 8;
constexpr int64_t kInvalid = 0x8000'0000;
// Identifiers of 29 bits, which are none of ours.
constexpr int64_t kExtended = 0x2000'0000;
// "No remote frame asks for it": of no consequence here.
constexpr int64_t kNoRemote = 0x4000'0000;

}  // namespace

Pdo::Pdo(ObjectDictionary& objects, const PdoConfig& config)
    : objects_(objects), direction_(config.direction), index_(config.index) {
  AddCommunication(config);
  AddMapping(config);
}

void Pdo::AddCommunication(const PdoConfig& config) {
  objects_.Add({index_, 0}, {.bytes = 1, .initial = 2});
  objects_.Add({index_, 1}, {.access = Access::kReadWrite,
                             .initial = config.identifier,
                             .write = [this](int64_t value) { return JudgeIdentifier(value); }});
  objects_.Add({index_, 2}, {.bytes = 1,
                             .access = Access::kReadWrite,
                             .initial = config.type,
                             .write = [this](int64_t value) { return JudgeType(value); }});
}

void Pdo::AddMapping(const PdoConfig& config) {
  const auto mapping = static_cast<uint16_t>(index_ + kMappingOffset);
  objects_.Add({mapping, 0}, {.bytes = 1,
                              .access = Access::kReadWrite,
                              .initial = static_cast<int64_t>(config.mapping.size()),
                              .write = [this](int64_t count) { return JudgeCount(count); }});
  for (uint8_t i = 0; i < kMostObjects; ++i) {
    objects_.Add({mapping, static_cast<uint8_t>(i + 1)},
                 {.access = Access::kReadWrite,
                  .initial = i < config.mapping.size() ? config.mapping[i] : 0,
                  .write = [this](int64_t entry) { return JudgeEntry(entry); }});
  }
}

bool Pdo::valid() const { return (objects_.Get({index_, 1}) & kInvalid) == 0; }

uint16_t Pdo::identifier() const {
  return static_cast<uint16_t>(objects_.Get({index_, 1}) & can::kMaxIdentifier);
}

uint8_t Pdo::type() const { return static_cast<uint8_t>(objects_.Get({index_, 2})); }

SdoAbort Pdo::JudgeIdentifier(int64_t value) const {
  const bool stays_valid = valid() && (value & kInvalid) == 0;
  const int64_t identifier = value & ~(kInvalid | kNoRemote);
  const bool possible = (value & kExtended) == 0 && identifier > 0 && identifier <= can::kMaxIdentifier;
  return possible && !(stays_valid && identifier != this->identifier()) ? SdoAbort::kNone
                                                                        : SdoAbort::kInvalidValue;
}

SdoAbort Pdo::JudgeType(int64_t value) const {
  constexpr int64_t kEventDriven = 254;
  // A transmit PDO that waits for an event would wait for ever: this node has none.
  const bool known = direction_ == PdoDirection::kTransmit
                         ? value >= 1 && value <= kLastSynchronous
                         : value <= kLastSynchronous || value >= kEventDriven;
  return known ? SdoAbort::kNone : SdoAbort::kInvalidValue;
}

std::optional<Pdo::Mapped> Pdo::Parse(int64_t entry) const {
  const ObjectId id{static_cast<uint16_t>(entry >> 16), static_cast<uint8_t>(entry >> 8 & 0xFF)};
  const Object* object = objects_.Find(id);
  const auto bits = static_cast<std::size_t>(entry & 0xFF);
  if (object == nullptr || !object->mappable || bits != std::size_t{8} * object->bytes ||
      (direction_ == PdoDirection::kReceive && object->access == Access::kReadOnly)) {
    return std::nullopt;
  }
  return Mapped{id, object->bytes};
}

SdoAbort Pdo::JudgeEntry(int64_t value) const {
  const auto mapping = static_cast<uint16_t>(index_ + kMappingOffset);
  if (valid() || objects_.Get({mapping, 0}) != 0) {
    return SdoAbort::kUnsupportedAccess;
  }
  return value == 0 || Parse(value) ? SdoAbort::kNone : SdoAbort::kNotMappable;
}

SdoAbort Pdo::JudgeCount(int64_t count) const {
  if (valid()) {
    return SdoAbort::kUnsupportedAccess;
  }
  if (count > kMostObjects) {
    return SdoAbort::kTooHigh;
  }
  const auto mapping = static_cast<uint16_t>(index_ + kMappingOffset);
  std::size_t bytes = 0;
  for (int64_t i = 1; i <= count; ++i) {
    const auto mapped = Parse(objects_.Get({mapping, static_cast<uint8_t>(i)}));
    if (!mapped) {
      return SdoAbort::kNotMappable;
    }
    bytes += mapped->bytes;
  }
  return bytes <= can::kMaxFrameBytes ? SdoAbort::kNone : SdoAbort::kPdoTooLong;
}

std::vector<Pdo::Mapped> Pdo::Mapping() const {
  const auto mapping = static_cast<uint16_t>(index_ + kMappingOffset);
  std::vector<Mapped> all;
  for (int64_t i = 1; i <= objects_.Get({mapping, 0}); ++i) {
    if (const auto mapped = Parse(objects_.Get({mapping, static_cast<uint8_t>(i)}))) {
      all.push_back(*mapped);
    }
  }
  return all;
}

can::Frame Pdo::Pack(bool wrong_order) const {
  can::Frame frame{.identifier = identifier()};
  for (const Mapped& mapped : Mapping()) {
    std::vector<uint8_t> bytes = ToBytes(objects_.Get(mapped.id), mapped.bytes);
    if (wrong_order && bytes.size() == 4) {
      std::rotate(bytes.begin(), bytes.begin() + 2, bytes.end());
    }
    std::copy(bytes.begin(), bytes.end(), frame.bytes.begin() + frame.size);
    frame.size = static_cast<uint8_t>(frame.size + bytes.size());
  }
  return frame;
}

bool Pdo::Unpack(const can::Frame& frame) {
  std::span<const uint8_t> left = frame.data();
  const std::vector<Mapped> mapping = Mapping();
  std::size_t needed = 0;
  for (const Mapped& mapped : mapping) {
    needed += mapped.bytes;
  }
  if (left.size() < needed) {
    return false;
  }
  for (const Mapped& mapped : mapping) {
    // A value that the object refuses is one that it does not take.
    objects_.Write(mapped.id, left.first(mapped.bytes));
    left = left.subspan(mapped.bytes);
  }
  return true;
}

}  // namespace mwidth::device::emulator
