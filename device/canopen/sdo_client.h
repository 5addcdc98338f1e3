// Reads and writes the objects of a node while nothing is urgent.
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>

#include "device/can/bus.h"
#include "device/canopen/objects.h"
#include "device/monotonic_clock.h"

namespace mwidth::device::canopen {

/// The node refused. what() says which object and why.
class SdoAborted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// "6060h" or "1016h:1".
std::string NameOf(const Object& object);

/// Waits half a second for each answer. Throws std::runtime_error, with what to do, where none comes. Not Rt.
class SdoClient {
 public:
  SdoClient(can::Bus& bus, uint8_t node, Now now) : bus_(bus), node_(node), now_(now) {}

  /// The object's value, its upper bytes 0. Throws SdoAborted, and std::runtime_error for another width.
  uint32_t Upload(const Object& object);
  /// Throws SdoAborted.
  void Download(const Object& object, uint32_t value);

 private:
  /// The first answer that `judge` takes for one to this request.
  template <typename Judge>
  uint32_t Exchange(const can::Frame& request, const Object& object, Judge judge);

  can::Bus& bus_;
  const uint8_t node_;
  const Now now_;
};

/// The first frame with this identifier; none within `patience_s`. Throws std::runtime_error where the bus is
/// lost. Not Rt.
std::optional<can::Frame> WaitFor(can::Bus& bus, uint16_t identifier, double patience_s, Now now);

}  // namespace mwidth::device::canopen
