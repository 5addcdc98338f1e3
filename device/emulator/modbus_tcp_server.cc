#include "device/emulator/modbus_tcp_server.h"

#include <array>
#include <boost/asio/read.hpp>
#include <chrono>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "device/emulator/answer_writer.h"

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
      : socket_(std::move(socket)), writer_(socket_, faults), unit_(unit), registers_(registers) {
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
    std::vector<uint8_t> answer(header_.begin(), header_.end());
    answer[4] = static_cast<uint8_t>((pdu.size() + 1) >> 8);
    answer[5] = static_cast<uint8_t>((pdu.size() + 1) & 0xFF);
    answer.insert(answer.end(), pdu.begin(), pdu.end());
    writer_.Write(std::move(answer), [self = shared_from_this()] { self->ReadHeader(); });
  }

  tcp::socket socket_;
  AnswerWriter<tcp::socket> writer_;
  const uint8_t unit_;
  ModbusRegisters& registers_;
  std::array<uint8_t, kHeaderBytes> header_{};
  std::vector<uint8_t> body_;
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
