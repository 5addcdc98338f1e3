#include "device/canopen/sdo.h"

#include <algorithm>
#include <array>
#include <utility>

#include "device/canopen/little_endian.h"

namespace mwidth::device::canopen {
namespace {

// Byte 0: the command; 1 and 2: the index; 3: the subindex; 4 to 7: the value.
constexpr std::size_t kIndexAt = 1;
constexpr std::size_t kSubindexAt = 3;
constexpr std::size_t kValueAt = 4;

constexpr uint8_t kDownload = 0x20;
constexpr uint8_t kDownloaded = 0x60;
constexpr uint8_t kUpload = 0x40;
constexpr uint8_t kUploaded = 0x40;
constexpr uint8_t kAbort = 0x80;
// What a command is stands in its three upper bits; below, of a transfer: how many of four bytes are not
// used, that the value is in this frame, that their number is given.
constexpr uint8_t kCommandBits = 0xE0;
constexpr uint8_t kUnusedShift = 2;
constexpr uint8_t kUnusedBits = 0x0C;
constexpr uint8_t kExpedited = 0x02;
constexpr uint8_t kSizeGiven = 0x01;

can::Frame Request(uint8_t node, const Object& object, uint8_t command) noexcept {
  can::Frame frame{.identifier = static_cast<uint16_t>(kSdoRequest + node), .size = can::kMaxFrameBytes};
  frame.bytes[0] = command;
  Put(frame, kIndexAt, 2, object.index);
  frame.bytes[kSubindexAt] = object.subindex;
  return frame;
}

bool IsAbout(const can::Frame& frame, const Object& object) noexcept {
  return !frame.remote && frame.size == can::kMaxFrameBytes && Get(frame, kIndexAt, 2) == object.index &&
         frame.bytes[kSubindexAt] == object.subindex;
}

constexpr std::array<std::pair<uint32_t, const char*>, 31> kAbortWords{{
    {0x0503'0000, "toggle bit not alternated"},
    {0x0504'0000, "SDO protocol timed out"},
    {0x0504'0001, "command specifier not valid or unknown"},
    {0x0504'0002, "invalid block size"},
    {0x0504'0003, "invalid sequence number"},
    {0x0504'0004, "CRC error"},
    {0x0504'0005, "out of memory"},
    {0x0601'0000, "unsupported access to an object"},
    {0x0601'0001, "attempt to read a write-only object"},
    {0x0601'0002, "attempt to write a read-only object"},
    {0x0602'0000, "object does not exist in the object dictionary"},
    {0x0604'0041, "object cannot be mapped to the PDO"},
    {0x0604'0042, "the objects to be mapped would exceed the PDO's length"},
    {0x0604'0043, "general parameter incompatibility"},
    {0x0604'0047, "general internal incompatibility in the device"},
    {0x0606'0000, "access failed due to a hardware error"},
    {0x0607'0010, "data type or length of the parameter does not match"},
    {0x0607'0012, "length of the parameter is too high"},
    {0x0607'0013, "length of the parameter is too low"},
    {0x0609'0011, "subindex does not exist"},
    {0x0609'0030, "invalid value for the parameter"},
    {0x0609'0031, "value of the parameter is too high"},
    {0x0609'0032, "value of the parameter is too low"},
    {0x0609'0036, "maximum value is less than minimum value"},
    {0x060A'0023, "resource not available: SDO connection"},
    {0x0800'0000, "general error"},
    {0x0800'0020, "data cannot be transferred or stored"},
    {0x0800'0021, "data cannot be transferred or stored because of local control"},
    {0x0800'0022, "data cannot be transferred or stored in the present device state"},
    {0x0800'0023, "no object dictionary is present"},
    {0x0800'0024, "no data available"},
}};

}  // namespace

can::Frame UploadRequest(uint8_t node, const Object& object) noexcept {
  return Request(node, object, kUpload);
}

can::Frame DownloadRequest(uint8_t node, const Object& object, uint32_t value) noexcept {
  const int unused = static_cast<int>(kValueAt) - object.size;
  can::Frame frame = Request(
      node, object, static_cast<uint8_t>(kDownload | unused << kUnusedShift | kExpedited | kSizeGiven));
  Put(frame, kValueAt, object.size, value);
  return frame;
}

SdoReply UploadReply(const can::Frame& frame, const Object& object) noexcept {
  if (!IsAbout(frame, object)) {
    return {};
  }
  const uint8_t command = frame.bytes[0];
  if (command == kAbort) {
    return {.kind = SdoKind::kAborted, .value = Get(frame, kValueAt, 4)};
  }
  if ((command & kCommandBits) != kUploaded) {
    return {};
  }
  const int size = static_cast<int>(kValueAt) - ((command & kUnusedBits) >> kUnusedShift);
  const bool fits = (command & kSizeGiven) == 0 || size == object.size;
  if ((command & kExpedited) == 0 || !fits) {
    return {.kind = SdoKind::kWrongSize};
  }
  return {.kind = SdoKind::kValue, .value = Get(frame, kValueAt, object.size)};
}

SdoReply DownloadReply(const can::Frame& frame, const Object& object) noexcept {
  if (!IsAbout(frame, object)) {
    return {};
  }
  if (frame.bytes[0] == kAbort) {
    return {.kind = SdoKind::kAborted, .value = Get(frame, kValueAt, 4)};
  }
  return (frame.bytes[0] & kCommandBits) == kDownloaded ? SdoReply{.kind = SdoKind::kTaken} : SdoReply{};
}

const char* AbortWords(uint32_t code) noexcept {
  const auto* const found = std::find_if(kAbortWords.begin(), kAbortWords.end(),
                                         [code](const auto& entry) { return entry.first == code; });
  return found != kAbortWords.end() ? found->second : "unknown abort code";
}

}  // namespace mwidth::device::canopen
