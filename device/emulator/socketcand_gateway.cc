#include "device/emulator/socketcand_gateway.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <optional>
#include <utility>
#include <vector>

#include "device/emulator/socketcand_text.h"

namespace mwidth::device::emulator {

namespace asio = boost::asio;
using asio::ip::tcp;
using std::chrono::microseconds;
using std::chrono::nanoseconds;

/// One connection; keeps itself alive by its own handlers, and the gateway in mind until it is closed.
class SocketcandGateway::Client : public std::enable_shared_from_this<Client> {
 public:
  Client(tcp::socket socket, SocketcandGateway& gateway)
      : socket_(std::move(socket)), timer_(socket_.get_executor()), gateway_(&gateway) {
    boost::system::error_code ignored;
    socket_.set_option(tcp::no_delay(true), ignored);
    // The kernel would hold megabytes for a client that reads nothing.
    socket_.set_option(tcp::socket::send_buffer_size(kMaxUnreadBytes), ignored);
  }

  void Start() {
    Tell("< hi >");
    Read();
  }

  void Show(const std::string& frame) {
    if (raw_) {
      Tell(frame);
    }
  }

  /// Hangs up, and has the gateway forget this.
  void Close() {
    if (auto* gateway = gateway_) {
      Leave();
      gateway->Forget(this);
    }
  }

  /// Hangs up, and forgets the gateway.
  void Leave() {
    gateway_ = nullptr;
    boost::system::error_code ignored;
    socket_.close(ignored);
  }

 private:
  void Read() {
    socket_.async_read_some(asio::buffer(part_), [self = shared_from_this()](auto error, std::size_t size) {
      if (error) {
        self->Close();
        return;
      }
      self->Acknowledge();
      self->received_.append(self->part_.data(), size);
      self->ObeyAll();
    });
  }

  // At once: a client without TCP_NODELAY (python-can) keeps its next frame back until then. The kernel
  // forgets the option with every answer.
  void Acknowledge() {
    const int on = 1;
    setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_QUICKACK, &on, sizeof on);
  }

  void ObeyAll() {
    while (gateway_ != nullptr) {
      const auto element = TakeElement(received_);
      if (!element) {
        break;
      }
      Obey(*element);
    }
    if (received_.size() > kMaxElementBytes) {
      Close();
    }
    if (gateway_ != nullptr) {
      Read();
    }
  }

  void Obey(const std::string& element) {
    const GatewayCommand command = ParseElement(element);
    if (!open_ && command.word != GatewayWord::kOpen) {
      Tell("< error unknown command >");
      return;
    }
    switch (command.word) {
      case GatewayWord::kOpen:
        Open(command.bus);
        break;
      case GatewayWord::kRawMode:
      case GatewayWord::kBcmMode:
        raw_ = command.word == GatewayWord::kRawMode;
        Tell("< ok >");
        break;
      case GatewayWord::kEcho:
        Tell("< echo >");
        break;
      case GatewayWord::kSend:
        gateway_->Relay(command.frame, this);
        break;
      case GatewayWord::kUnknown:
        Tell("< error unknown command >");
        break;
    }
  }

  void Open(const std::string& bus) {
    open_ = bus == gateway_->name_;
    if (open_) {
      Tell("< ok >");
      return;
    }
    // Said in one piece, so that it is gone before the connection is.
    boost::system::error_code ignored;
    asio::write(socket_, asio::buffer(std::string("< error could not open bus >")), ignored);
    Close();
  }

  void Tell(const std::string& text) {
    if (unsent_.size() + text.size() > kMaxUnreadBytes) {
      Close();
      return;
    }
    unsent_ += text;
    if (!writing_) {
      Write();
    }
  }

  // All that is unsent, or the next byte of it.
  void Write() {
    const nanoseconds dribble(gateway_->faults_.dribble_ns);
    const std::size_t size = dribble.count() > 0 ? 1 : unsent_.size();
    sending_ = unsent_.substr(0, size);
    unsent_.erase(0, size);
    writing_ = true;
    asio::async_write(socket_, asio::buffer(sending_),
                      [self = shared_from_this(), dribble](auto error, std::size_t) {
                        self->writing_ = false;
                        if (error) {
                          self->Close();
                        } else if (!self->unsent_.empty()) {
                          self->WriteAfter(dribble);
                        }
                      });
  }

  void WriteAfter(nanoseconds pause) {
    if (gateway_ == nullptr) {
      return;
    }
    if (pause.count() == 0) {
      Write();
      return;
    }
    writing_ = true;
    timer_.expires_after(pause);
    timer_.async_wait([self = shared_from_this()](auto error) {
      if (!error && self->gateway_ != nullptr) {
        self->Write();
      }
    });
  }

  tcp::socket socket_;
  asio::steady_timer timer_;
  /// None once it is closed.
  SocketcandGateway* gateway_;
  bool open_ = false;
  bool raw_ = false;
  bool writing_ = false;
  std::array<char, 1024> part_{};
  std::string received_;
  std::string unsent_;
  std::string sending_;
};

SocketcandGateway::SocketcandGateway(asio::io_context& context, const std::string& address, uint16_t port,
                                     std::string name, TakeFrame take, const LinkFaults& faults)
    : acceptor_(context, tcp::endpoint(asio::ip::make_address(address), port)),
      address_(address),
      name_(std::move(name)),
      take_(std::move(take)),
      faults_(faults) {
  Accept();
}

SocketcandGateway::~SocketcandGateway() {
  for (const auto& client : clients_) {
    client->Leave();
  }
}

std::string SocketcandGateway::Where() const {
  return address_ + ":" + std::to_string(acceptor_.local_endpoint().port());
}

void SocketcandGateway::Accept() {
  acceptor_.async_accept([this](auto error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) {
      return;
    }
    // Whoever is too many is hung up on.
    if (!error && clients_.size() < kMaxClients) {
      clients_.push_back(std::make_shared<Client>(std::move(socket), *this));
      clients_.back()->Start();
    }
    Accept();
  });
}

void SocketcandGateway::Relay(const can::Frame& frame, const Client* from) {
  const auto now =
      std::chrono::duration_cast<microseconds>(std::chrono::system_clock::now().time_since_epoch());
  const std::string text = FrameElement(frame, now);
  // Of a copy: showing a frame to a client that reads nothing closes it.
  for (const auto& client : std::vector(clients_.begin(), clients_.end())) {
    if (client.get() != from) {
      client->Show(text);
    }
  }
  if (from != nullptr) {
    take_(frame);
  }
}

void SocketcandGateway::Send(const can::Frame& frame) { Relay(frame, nullptr); }

void SocketcandGateway::Forget(const Client* client) {
  clients_.remove_if([&](const auto& known) { return known.get() == client; });
}

}  // namespace mwidth::device::emulator
