#include "device/can/socketcand_bus.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/connect.hpp>
#include <chrono>
#include <stdexcept>
#include <utility>

#include "device/can/wait.h"

namespace mwidth::device::can {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

// For each step of joining; nobody waits for it but the thread that connects.
constexpr std::chrono::seconds kConnectPatience{2};

// Frames of no use that one wait passes over when its time is up: a flood must not hold the loop.
constexpr int kMostPassedOver = 64;

}  // namespace

SocketcandBus::SocketcandBus(Socketcand config) : config_(std::move(config)) {}

void SocketcandBus::Fail(const std::string& reason, const std::string& remedy) {
  joined_ = false;
  error_code ignored;
  socket_.close(ignored);
  throw std::runtime_error("CAN gateway at " + config_.host + ":" + std::to_string(config_.port) + ": " +
                           reason + "; " + remedy);
}

void SocketcandBus::ConnectTcp() {
  const std::string remedy = "check that socketcand runs there, its address and its port";
  error_code error;
  asio::ip::tcp::resolver resolver(context_);
  const auto addresses = resolver.resolve(config_.host, std::to_string(config_.port), error);
  if (error) {
    Fail(error.message(), remedy);
  }
  error = asio::error::timed_out;
  asio::async_connect(socket_, addresses,
                      [&error](const error_code& result, const auto& /*endpoint*/) { error = result; });
  context_.restart();
  context_.run_for(kConnectPatience);
  if (!context_.stopped()) {
    error_code ignored;
    socket_.close(ignored);
    context_.run();  // The handler refers to what stands here.
    error = asio::error::timed_out;
  }
  if (error) {
    Fail(error.message(), remedy);
  }
}

void SocketcandBus::Connect() {
  error_code ignored;
  socket_.close(ignored);
  joined_ = false;
  begin_ = end_ = 0;
  ConnectTcp();
  socket_.set_option(asio::ip::tcp::no_delay(true));
  socket_.non_blocking(true);
  joined_ = true;
  Expect("", ElementKind::kHi);
  Expect("< open " + config_.interface + " >", ElementKind::kOk);
  Expect("< rawmode >", ElementKind::kOk);
}

void SocketcandBus::Expect(std::string_view request, ElementKind answer) {
  SendText(request);
  const int64_t deadline_ns = NowNs() + std::chrono::nanoseconds(kConnectPatience).count();
  // Frames may come between the answers.
  while (true) {
    const Element element = Next(deadline_ns);
    if (element.kind == answer) {
      return;
    }
    if (!joined_) {
      Fail("it hung up", "check that it offers the interface " + config_.interface);
    }
    if (element.kind == ElementKind::kRefusal) {
      Fail("it does not open " + config_.interface, "check that it offers this interface, and that it is up");
    }
    if (element.kind == ElementKind::kIncomplete || NowNs() >= deadline_ns) {
      Fail("it does not answer as socketcand does", "check that nothing else listens there");
    }
  }
}

bool SocketcandBus::SendText(std::string_view text) noexcept {
  error_code error;
  // MSG_NOSIGNAL is Asio's own. It sends all or, without blocking, what fits.
  const bool sent =
      joined_ && socket_.send(asio::buffer(text.data(), text.size()), 0, error) == text.size() && !error;
  if (!sent && joined_) {
    joined_ = false;
    ++counters_.lost;
  }
  return sent;
}

bool SocketcandBus::Send(const Frame& frame) noexcept {
  const bool sent = SendText(ToSend(frame).view());
  counters_.not_sent += sent ? 0 : 1;
  return sent;
}

bool SocketcandBus::Read() noexcept {
  if (begin_ > 0) {
    std::copy(text_.begin() + static_cast<std::ptrdiff_t>(begin_),
              text_.begin() + static_cast<std::ptrdiff_t>(end_), text_.begin());
    end_ -= std::exchange(begin_, 0);
  }
  error_code error;
  end_ += socket_.receive(asio::buffer(text_.data() + end_, text_.size() - end_), 0, error);
  if (error && error != asio::error::would_block && error != asio::error::interrupted) {
    joined_ = false;
    ++counters_.lost;
  }
  // A gateway with Nagle's algorithm sends its next line only when the one before is acknowledged, and the
  // kernel forgets this wish with every acknowledgement.
  const int on = 1;
  setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_QUICKACK, &on, sizeof on);
  return joined_;
}

Element SocketcandBus::Next(int64_t deadline_ns) noexcept {
  // However short the pieces are in which a line comes, the time is bounded.
  constexpr int kMostReads = 8;
  for (int reads = 0; joined_ && (reads < kMostReads || NowNs() < deadline_ns); ++reads) {
    const Element element = FirstElement({text_.data() + begin_, end_ - begin_});
    begin_ += element.size;
    if (element.kind != ElementKind::kIncomplete) {
      return element;
    }
    const std::size_t before = end_ - begin_;
    if (!Read() || (end_ == before && !WaitToRead(socket_.native_handle(), deadline_ns))) {
      break;
    }
  }
  return {};
}

Reception SocketcandBus::Receive(Frame& frame, int64_t deadline_ns) noexcept {
  for (int passed_over = 0; passed_over < kMostPassedOver || NowNs() < deadline_ns; ++passed_over) {
    const Element element = Next(deadline_ns);
    switch (element.kind) {
      case ElementKind::kFrame:
        frame = element.frame;
        return Reception::kFrame;
      case ElementKind::kIncomplete:
        return joined_ ? Reception::kNothing : Reception::kLost;
      case ElementKind::kBusOff:
        ++counters_.error_frames;
        ++counters_.lost;
        joined_ = false;
        return Reception::kLost;
      case ElementKind::kErrorFrame:
        ++counters_.error_frames;
        break;
      case ElementKind::kNotClassical:
        ++counters_.not_classical;
        break;
      case ElementKind::kHi:
      case ElementKind::kOk:
      case ElementKind::kRefusal:
      case ElementKind::kMalformed:
        ++counters_.malformed;
        break;
    }
  }
  return Reception::kNothing;
}

}  // namespace mwidth::device::can
