// A CAN controller of this host, by the kernel's SocketCAN.
#pragma once

#include <linux/can.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <string>

#include "device/emulator/can_bus.h"

namespace mwidth::device::emulator {

/// Lives on one io_context with one thread.
class SocketcanBus final : public CanBus {
 public:
  /// `take` gets the frames of others with identifiers of 11 bits. Throws std::system_error, also where the
  /// kernel has no CAN.
  SocketcanBus(boost::asio::io_context& context, std::string interface, TakeFrame take);

  void Send(const can::Frame& frame) override;
  std::string Where() const override { return interface_; }

 private:
  void Read();

  boost::asio::posix::stream_descriptor socket_;
  const std::string interface_;
  const TakeFrame take_;
  can_frame received_{};
};

}  // namespace mwidth::device::emulator
