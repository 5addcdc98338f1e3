// A CAN bus that an emulated node is on.
#pragma once

#include <functional>
#include <string>

#include "device/can/frame.h"

namespace mwidth::device::emulator {

/// Takes a frame that another node sent.
using TakeFrame = std::function<void(const can::Frame&)>;

class CanBus {
 public:
  CanBus() = default;
  CanBus(const CanBus&) = delete;
  CanBus& operator=(const CanBus&) = delete;
  virtual ~CanBus() = default;

  /// Sends a frame of the node's to all others; one that cannot be sent is lost, as on a bus.
  virtual void Send(const can::Frame& frame) = 0;
  virtual std::string Where() const = 0;
};

}  // namespace mwidth::device::emulator
