// A CAN bus of its own, reached by the socketcand protocol over TCP.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <string>

#include "device/emulator/can_bus.h"
#include "device/emulator/faults.h"

namespace mwidth::device::emulator {

/// A bus with one emulated node and the clients: a frame of one of them goes to the node and to all other
/// clients in raw mode. Lives on one io_context with one thread.
class SocketcandGateway final : public CanBus {
 public:
  static constexpr std::size_t kMaxClients = 16;
  /// A client that leaves more than this unread is dropped.
  static constexpr std::size_t kMaxUnreadBytes = 65'536;

  /// Listens on `address` and `port` (0: any free one) for clients that want the bus `name`; `take` gets what
  /// they send. References outlive it. Throws boost::system::system_error.
  SocketcandGateway(boost::asio::io_context& context, const std::string& address, uint16_t port,
                    std::string name, TakeFrame take, const LinkFaults& faults);
  ~SocketcandGateway() override;
  SocketcandGateway(const SocketcandGateway&) = delete;
  SocketcandGateway& operator=(const SocketcandGateway&) = delete;

  void Send(const can::Frame& frame) override;
  std::string Where() const override;

 private:
  class Client;

  void Accept();
  void Relay(const can::Frame& frame, const Client* from);
  void Forget(const Client* client);

  boost::asio::ip::tcp::acceptor acceptor_;
  const std::string address_;
  const std::string name_;
  const TakeFrame take_;
  const LinkFaults& faults_;
  std::list<std::shared_ptr<Client>> clients_;
};

}  // namespace mwidth::device::emulator
