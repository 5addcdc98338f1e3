// A CAN controller of this host.
#pragma once

#include <boost/asio/generic/raw_protocol.hpp>
#include <boost/asio/io_context.hpp>

#include "device/can/bus.h"

namespace mwidth::device::can {

/// The kernel's SocketCAN. Its error frames are asked for where they tell of a controller in trouble: bus-off
/// is the loss of the bus.
class SocketCanBus final : public Bus {
 public:
  explicit SocketCanBus(SocketCan config);

  void Connect() override;
  bool Send(const Frame& frame) noexcept override;
  Reception Receive(Frame& frame, int64_t deadline_ns) noexcept override;
  const BusCounters& counters() const noexcept override { return counters_; }

 private:
  Reception Lost() noexcept;

  const SocketCan config_;
  boost::asio::io_context context_;
  boost::asio::generic::raw_protocol::socket socket_{context_};
  bool joined_ = false;
  BusCounters counters_;
};

}  // namespace mwidth::device::can
