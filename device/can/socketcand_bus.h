// A CAN controller of another host, behind a socketcand gateway.
#pragma once

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <string>
#include <string_view>

#include "device/can/bus.h"
#include "device/can/socketcand.h"

namespace mwidth::device::can {

/// The socketcand protocol in its raw mode, over TCP. A line that does not fit into the socket at once is the
/// loss of the bus, since half a line would spoil the next.
class SocketcandBus final : public Bus {
 public:
  explicit SocketcandBus(Socketcand config);

  void Connect() override;
  bool Send(const Frame& frame) noexcept override;
  Reception Receive(Frame& frame, int64_t deadline_ns) noexcept override;
  const BusCounters& counters() const noexcept override { return counters_; }

 private:
  [[noreturn]] void Fail(const std::string& reason, const std::string& remedy);
  void ConnectTcp();
  /// Says `request`, if any, and waits for the answer of this kind.
  void Expect(std::string_view request, ElementKind answer);
  bool SendText(std::string_view text) noexcept;
  /// Takes the first element from what has come; kIncomplete where none is there by the deadline.
  Element Next(int64_t deadline_ns) noexcept;
  /// False where the gateway hung up.
  bool Read() noexcept;

  const Socketcand config_;
  boost::asio::io_context context_;
  boost::asio::ip::tcp::socket socket_{context_};
  bool joined_ = false;
  // What has come and is not yet used: text_[begin_, end_).
  std::array<char, 4096> text_{};
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  BusCounters counters_;
};

}  // namespace mwidth::device::can
