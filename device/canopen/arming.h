// The way of a drive to "operation enabled", a step a tick.
#pragma once

#include <cstdint>
#include <optional>

#include "device/can/frame.h"
#include "device/canopen/canopen_drive_config.h"
#include "device/canopen/objects.h"
#include "device/canopen/sdo.h"
#include "device/drive.h"

namespace mwidth::device::canopen {

/// First reads back that the drive takes the force away by itself when our heartbeat is missing (1016h:1,
/// 6007h), then walks its state machine. All Rt.
class Arming {
 public:
  /// `config` outlives it.
  explicit Arming(const CanopenDriveConfig& config) noexcept : config_(config) {}

  /// What to answer, and what to send: an SDO request, or a controlword with no torque.
  struct Step {
    Enabling enabling = Enabling::kPending;
    std::optional<can::Frame> request;
    std::optional<uint16_t> controlword;
  };

  /// The next step, by what the drive says of its state now. After an answer other than kPending it begins
  /// anew.
  Step Next(uint16_t statusword, int64_t now_ns) noexcept;
  /// An SDO reply came.
  void Hear(const can::Frame& reply) noexcept;
  void Reset() noexcept { stage_ = Stage::kBegin; }
  bool under_way() const noexcept { return stage_ != Stage::kBegin; }

 private:
  enum class Stage : uint8_t { kBegin, kAskTimeout, kAskReaction, kWalk };

  Step Ask(Stage stage, const Object& object, int64_t now_ns) noexcept;
  Step Await(int64_t now_ns) noexcept;
  Step Walk(uint16_t statusword) noexcept;
  Step End(Enabling enabling) noexcept;
  bool Protects(uint32_t value) const noexcept;

  const CanopenDriveConfig& config_;
  Stage stage_ = Stage::kBegin;
  Object asked_;
  int64_t asked_ns_ = 0;
  SdoReply reply_;
  uint16_t controlword_ = 0;
};

}  // namespace mwidth::device::canopen
