#include "device/emulator/object_dictionary.h"

#include <utility>

namespace mwidth::device::emulator {

std::vector<uint8_t> ToBytes(int64_t value, std::size_t bytes) {
  std::vector<uint8_t> coded(bytes);
  for (std::size_t i = 0; i < bytes; ++i) {
    coded[i] = static_cast<uint8_t>(static_cast<uint64_t>(value) >> (8 * i));
  }
  return coded;
}

int64_t FromBytes(std::span<const uint8_t> bytes, bool is_signed) {
  uint64_t value = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    value |= static_cast<uint64_t>(bytes[i]) << (8 * i);
  }
  const uint64_t sign = uint64_t{1} << (8 * bytes.size() - 1);
  return static_cast<int64_t>(is_signed && (value & sign) != 0 ? value - 2 * sign : value);
}

void ObjectDictionary::Add(ObjectId id, Object object) {
  const int64_t initial = object.initial;
  objects_.insert_or_assign(id, Stored{std::move(object), initial});
}

const Object* ObjectDictionary::Find(ObjectId id) const {
  const auto found = objects_.find(id);
  return found == objects_.end() ? nullptr : &found->second.object;
}

int64_t ObjectDictionary::Get(ObjectId id) const {
  const Stored& stored = objects_.at(id);
  return stored.object.read ? stored.object.read() : stored.value;
}

void ObjectDictionary::Set(ObjectId id, int64_t value) { objects_.at(id).value = value; }

SdoAbort ObjectDictionary::Missing(ObjectId id) const {
  if (objects_.contains(id)) {
    return SdoAbort::kNone;
  }
  const auto next = objects_.lower_bound({id.index, 0});
  const bool has_others = next != objects_.end() && next->first.index == id.index;
  return has_others ? SdoAbort::kNoSubindex : SdoAbort::kNoObject;
}

SdoAbort ObjectDictionary::Read(ObjectId id, std::vector<uint8_t>& bytes) const {
  if (const SdoAbort missing = Missing(id); missing != SdoAbort::kNone) {
    return missing;
  }
  bytes = ToBytes(Get(id), objects_.at(id).object.bytes);
  return SdoAbort::kNone;
}

SdoAbort ObjectDictionary::Write(ObjectId id, std::span<const uint8_t> bytes) {
  if (const SdoAbort missing = Missing(id); missing != SdoAbort::kNone) {
    return missing;
  }
  Stored& stored = objects_.at(id);
  const Object& object = stored.object;
  if (object.access == Access::kReadOnly) {
    return SdoAbort::kReadOnly;
  }
  if (bytes.size() != object.bytes) {
    return bytes.size() > object.bytes ? SdoAbort::kTooLong : SdoAbort::kTooShort;
  }
  const int64_t value = FromBytes(bytes, object.is_signed);
  if (object.max && value > *object.max) {
    return SdoAbort::kTooHigh;
  }
  if (object.min && value < *object.min) {
    return SdoAbort::kTooLow;
  }
  const SdoAbort refusal = object.write ? object.write(value) : SdoAbort::kNone;
  if (refusal == SdoAbort::kNone) {
    stored.value = value;
  }
  return refusal;
}

void ObjectDictionary::Reset(uint16_t first, uint16_t last) {
  for (auto& [id, stored] : objects_) {
    if (id.index >= first && id.index <= last) {
      stored.value = stored.object.initial;
    }
  }
}

}  // namespace mwidth::device::emulator
