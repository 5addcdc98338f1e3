#include "device/emulator/sdo_server.h"

#include <algorithm>
#include <cstddef>

namespace mwidth::device::emulator {
namespace {

using Bytes = std::vector<uint8_t>;

constexpr std::size_t kSdoBytes = 8;
constexpr std::size_t kDataPlace = 4;
constexpr std::size_t kMostData = 4;
// Command specifiers, in bits 5 to 7 of the first byte.
constexpr uint8_t kSpecifier = 0xE0;
// Index and subindex, behind the command.
constexpr std::size_t kMultiplexorBytes = 3;
constexpr uint8_t kDownload = 0x20;
constexpr uint8_t kUpload = 0x40;
constexpr uint8_t kAbort = 0x80;
constexpr uint8_t kDownloaded = 0x60;
// Bits of an expedited transfer: that it is one, and that bits 2 and 3 tell how many bytes it lacks of 4.
constexpr uint8_t kExpedited = 0x02;
constexpr uint8_t kSized = 0x01;

// The answer to `request` that begins with `command` and carries `data`.
Bytes Reply(uint8_t command, std::span<const uint8_t> request, std::span<const uint8_t> data) {
  Bytes reply(kSdoBytes);
  reply[0] = command;
  std::copy_n(request.begin() + 1, kMultiplexorBytes, reply.begin() + 1);
  std::copy_n(data.begin(), std::min(data.size(), kMostData), reply.begin() + 1 + kMultiplexorBytes);
  return reply;
}

Bytes Refuse(std::span<const uint8_t> request, SdoAbort reason) {
  return Reply(kAbort, request, ToBytes(static_cast<int64_t>(reason), kMostData));
}

Bytes Upload(std::span<const uint8_t> request, ObjectId id, const ObjectDictionary& objects) {
  Bytes data;
  if (const SdoAbort refusal = objects.Read(id, data); refusal != SdoAbort::kNone) {
    return Refuse(request, refusal);
  }
  const std::size_t lacking = kMostData - data.size();
  return Reply(static_cast<uint8_t>(kUpload | lacking << 2 | kExpedited | kSized), request, data);
}

Bytes Download(std::span<const uint8_t> request, ObjectId id, ObjectDictionary& objects) {
  if ((request[0] & kExpedited) == 0) {
    return Refuse(request, SdoAbort::kUnknownCommand);
  }
  std::size_t size = kMostData - (request[0] >> 2 & 3);
  if ((request[0] & kSized) == 0) {
    // The length is the object's own.
    const Object* object = objects.Find(id);
    size = object != nullptr ? object->bytes : kMostData;
  }
  const SdoAbort refusal = objects.Write(id, request.subspan(kDataPlace, size));
  return refusal == SdoAbort::kNone ? Reply(kDownloaded, request, {}) : Refuse(request, refusal);
}

}  // namespace

std::optional<Bytes> AnswerSdo(std::span<const uint8_t> request, ObjectDictionary& objects, bool broken) {
  if (request.size() != kSdoBytes || (request[0] & kSpecifier) == kAbort) {
    return std::nullopt;
  }
  if (broken) {
    return Refuse(request, SdoAbort::kGeneral);
  }
  const ObjectId id{static_cast<uint16_t>(request[1] | request[2] << 8), request[3]};
  switch (request[0] & kSpecifier) {
    case kUpload:
      return Upload(request, id, objects);
    case kDownload:
      return Download(request, id, objects);
    default:
      return Refuse(request, SdoAbort::kUnknownCommand);
  }
}

}  // namespace mwidth::device::emulator
