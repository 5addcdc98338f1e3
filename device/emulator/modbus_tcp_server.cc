#include "device/emulator/modbus_tcp_server.h"

#include <algorithm>
#include <array>
#include <boost/asio/read.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace mwidth::device::emulator {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using std::chrono::nanoseconds;
using std::chrono::steady_clock;

constexpr std::size_t kHeaderBytes = 7;
constexpr std::size_t kMostBytes = 254;

/// One connection; keeps itself alive by its own handlers.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(tcp::socket socket, uint8_t unit, ModbusRegisters& registers, const LinkFaults& faults)
      : socket_(std::move(socket)),
        timer_(socket_.get_executor()),
        unit_(unit),
        registers_(registers),
        faults_(faults) {
    socket_.set_option(tcp::no_delay(true));
  }

  void ReadHeader() {
    asio::async_read(socket_, asio::buffer(header_), [self = shared_from_this()](auto error, std::size_t) {
      if (!error) {
        self->ReadBody();
      }
    });
  }

 private:
  void ReadBody() {
    const std::size_t length = static_cast<std::size_t>(header_[4]) << 8 | header_[5];
    // The unit, which has been read, counts as well; what cannot be right ends the connection.
    if (header_[2] != 0 || header_[3] != 0 || length < 2 || length > kMostBytes) {
      return;
    }
    body_.resize(length - 1);
    asio::async_read(socket_, asio::buffer(body_), [self = shared_from_this()](auto error, std::size_t) {
      if (!error) {
        self->Answer();
      }
    });
  }

  void Answer() {
    const int64_t now_ns = steady_clock::now().time_since_epoch() / nanoseconds(1);
    std::vector<uint8_t> pdu;
    if (header_[6] == unit_) {
      pdu = registers_.Answer(body_, now_ns);
    }
    if (pdu.empty()) {
      ReadHeader();
      return;
    }
    answer_.assign(header_.begin(), header_.end());
    answer_[4] = static_cast<uint8_t>((pdu.size() + 1) >> 8);
    answer_[5] = static_cast<uint8_t>((pdu.size() + 1) & 0xFF);
    answer_.insert(answer_.end(), pdu.begin(), pdu.end());
    Later(nanoseconds(faults_.delay_ns), 0);
  }

  // Writes the answer from `sent` on after a pause.
  void Later(nanoseconds pause, std::size_t sent) {
    if (pause.count() == 0) {
      Write(sent);
      return;
    }
    timer_.expires_after(pause);
    timer_.async_wait([self = shared_from_this(), sent](auto error) {
      if (!error) {
        self->Write(sent);
      }
    });
  }

  void Write(std::size_t sent) {
    const nanoseconds dribble(faults_.dribble_ns);
    const auto left = std::span<const uint8_t>(answer_).subspan(sent);
    const std::size_t size = dribble.count() > 0 ? 1 : left.size();
    asio::async_write(socket_, asio::buffer(left.data(), size),
                      [self = shared_from_this(), sent = sent + size, dribble](auto error, std::size_t) {
                        if (error) {
                          return;
                        }
                        if (sent < self->answer_.size()) {
                          self->Later(dribble, sent);
                        } else {
                          self->ReadHeader();
                        }
                      });
  }

  tcp::socket socket_;
  asio::steady_timer timer_;
  const uint8_t unit_;
  ModbusRegisters& registers_;
  const LinkFaults& faults_;
  std::array<uint8_t, kHeaderBytes> header_{};
  std::vector<uint8_t> body_;
  std::vector<uint8_t> answer_;
};

}  // namespace

ModbusTcpServer::ModbusTcpServer(asio::io_context& context, const std::string& address, uint16_t port,
                                 uint8_t unit, ModbusRegisters& registers, const LinkFaults& faults)
    : acceptor_(context, tcp::endpoint(asio::ip::make_address(address), port)),
      unit_(unit),
      registers_(registers),
      faults_(faults) {
  Accept();
}

void ModbusTcpServer::Accept() {
  acceptor_.async_accept([this](auto error, tcp::socket socket) {
    if (!error) {
      std::make_shared<Connection>(std::move(socket), unit_, registers_, faults_)->ReadHeader();
    }
    if (acceptor_.is_open()) {
      Accept();
    }
  });
}

}  // namespace mwidth::device::emulator
