// Expedited SDO (CiA 301, 7.2.4.3): one frame asks, one answers, and a value has at most four bytes.
#pragma once

#include <cstdint>

#include "device/can/frame.h"
#include "device/canopen/objects.h"

namespace mwidth::device::canopen {

/// Asks `node` for an object, or to take a value for it. Rt.
can::Frame UploadRequest(uint8_t node, const Object& object) noexcept;
can::Frame DownloadRequest(uint8_t node, const Object& object, uint32_t value) noexcept;

enum class SdoKind : uint8_t {
  /// The object's value; it was taken.
  kValue,
  kTaken,
  /// The node refuses, with a code.
  kAborted,
  /// A value of another width, or in segments: nothing that we ask for needs them.
  kWrongSize,
  /// An answer to something else, or none at all.
  kOther,
};

struct SdoReply {
  SdoKind kind = SdoKind::kOther;
  /// The value, its upper bytes 0, or the abort code.
  uint32_t value = 0;
};

/// What `frame`, of the node's reply identifier, answers to an upload or a download of `object`. Any bytes.
/// Rt.
SdoReply UploadReply(const can::Frame& frame, const Object& object) noexcept;
SdoReply DownloadReply(const can::Frame& frame, const Object& object) noexcept;

/// What an abort code means (CiA 301, table 22); "unknown abort code" where it is none of these.
const char* AbortWords(uint32_t code) noexcept;

}  // namespace mwidth::device::canopen
