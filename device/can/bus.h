// A CAN bus, as a node of it sees it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "device/can/bus_config.h"
#include "device/can/frame.h"

namespace mwidth::device::can {

/// How a wait for a frame ended.
enum class Reception : uint8_t {
  kFrame,
  /// Nothing that counts came in time.
  kNothing,
  /// The bus is gone: bus-off, an interface that is down, a gateway that hung up.
  kLost,
};

/// What came and was not used, or could not be sent, since the bus was made.
struct BusCounters {
  /// Frames with identifiers of 29 bits, and of CAN FD.
  uint64_t not_classical = 0;
  /// Errors of the bus, as its controller reports them.
  uint64_t error_frames = 0;
  /// Text of a gateway that is none.
  uint64_t malformed = 0;
  uint64_t not_sent = 0;
  uint64_t lost = 0;
};

/// One thread at a time. Frames that this end sends do not come back to it.
class Bus {
 public:
  Bus() = default;
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;
  virtual ~Bus() = default;

  /// Joins the bus, anew where it was joined before. Takes a few seconds at most; throws std::runtime_error,
  /// with what to do.
  virtual void Connect() = 0;
  /// False where the frame was not taken at once. Never blocks. Rt.
  virtual bool Send(const Frame& frame) noexcept = 0;
  /// Waits for a data or remote frame with an identifier of 11 bits, at most until `deadline_ns` of
  /// CLOCK_MONOTONIC and the few microseconds of the last system call; a deadline in the past takes what is
  /// there. Rt.
  virtual Reception Receive(Frame& frame, int64_t deadline_ns) noexcept = 0;
  virtual const BusCounters& counters() const noexcept = 0;
};

/// "can0", or "can0 of gateway:29536".
std::string NameOf(const BusConfig& config);

/// Not yet connected.
std::unique_ptr<Bus> MakeBus(const BusConfig& config);

}  // namespace mwidth::device::can
