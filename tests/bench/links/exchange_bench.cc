// One tick's exchange over Modbus TCP, beside the same bytes by bare send and recv: exchange by exchange, so
// that whatever disturbs the host disturbs both.
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <span>
#include <stdexcept>
#include <system_error>
#include <vector>

#include "device/modbus/frame.h"
#include "device/modbus/link.h"
#include "tests/bench/links/answering_peer.h"

namespace mwidth::bench {
namespace {

namespace modbus = device::modbus;

constexpr int kRounds = 5;
constexpr int kExchanges = 20'000;
constexpr int64_t kPatienceNs = 1'000'000'000;

int64_t NowNs() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

/// The same bytes without anything that looks at them.
class BareConnection {
 public:
  explicit BareConnection(uint16_t port) : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port);
    if (connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof(address)) != 0) {
      throw std::system_error(errno, std::generic_category(), "the peer does not answer");
    }
    constexpr int kOn = 1;
    setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &kOn, sizeof(kOn));
  }
  BareConnection(const BareConnection&) = delete;
  BareConnection& operator=(const BareConnection&) = delete;
  ~BareConnection() { close(socket_); }

  void Exchange(const modbus::Request& request) {
    std::array<uint8_t, modbus::kMaxTcpBytes> frame{};
    const std::size_t size = modbus::WrapTcp(request, 1, 1, frame);
    if (send(socket_, frame.data(), size, MSG_NOSIGNAL) < 0 ||
        recv(socket_, frame.data(), frame.size(), 0) <= 0) {
      throw std::system_error(errno, std::generic_category(), "the peer is gone");
    }
  }

 private:
  int socket_;
};

/// A tick: what is sent, one after the other.
struct Exchanges {
  const char* name;
  std::vector<modbus::Request> requests;
};

std::vector<Exchanges> Ticks() {
  constexpr std::array<uint16_t, 1> kForce{0};
  return {{"read position, write force (functions 3 and 16)",
           {modbus::ReadRegisters(100, 2), modbus::WriteRegisters(200, kForce)}},
          {"both in one request (function 23)", {modbus::ReadWriteRegisters(100, 2, 200, kForce)}}};
}

template <typename Exchange>
int64_t Time(const Exchanges& tick, Exchange exchange) {
  const int64_t begin_ns = NowNs();
  for (const modbus::Request& request : tick.requests) {
    exchange(request);
  }
  return NowNs() - begin_ns;
}

int64_t Percentile(std::vector<int64_t>& times_ns, double fraction) {
  const auto nth =
      times_ns.begin() + static_cast<std::ptrdiff_t>(fraction * static_cast<double>(times_ns.size()));
  std::nth_element(times_ns.begin(), nth, times_ns.end());
  return *nth;
}

void Compare(const Exchanges& tick) {
  std::printf("%s\n  round  link p50 us  bare p50 us  ratio   link p99 us  bare p99 us  ratio\n", tick.name);
  AnsweringPeer link_peer;
  AnsweringPeer bare_peer;
  modbus::Link link({.peer = modbus::TcpAddress{.host = "127.0.0.1", .port = link_peer.port()}, .unit = 1});
  link.Connect();
  BareConnection bare(bare_peer.port());
  std::array<uint16_t, modbus::kMaxRegisters> values{};
  for (int round = 1; round <= kRounds; ++round) {
    std::vector<int64_t> link_ns;
    std::vector<int64_t> bare_ns;
    for (int i = 0; i < kExchanges; ++i) {
      link_ns.push_back(Time(tick, [&](const modbus::Request& request) {
        if (link.Exchange(request, values, NowNs() + kPatienceNs) != modbus::Outcome::kAnswered) {
          throw std::runtime_error("the link was not answered");
        }
      }));
      bare_ns.push_back(Time(tick, [&](const modbus::Request& request) { bare.Exchange(request); }));
    }
    std::printf("  %5d", round);
    for (const double fraction : {0.5, 0.99}) {
      const auto ours = static_cast<double>(Percentile(link_ns, fraction));
      const auto bares = static_cast<double>(Percentile(bare_ns, fraction));
      std::printf("  %11.2f  %11.2f  %5.3f", ours * 1e-3, bares * 1e-3, ours / bares);
    }
    std::printf("\n");
  }
}

}  // namespace
}  // namespace mwidth::bench

int main() {
  // This thread on one CPU, its peers on another: where the scheduler puts them would decide the ratio.
  mwidth::bench::PinTo(0);
  try {
    for (const auto& tick : mwidth::bench::Ticks()) {
      mwidth::bench::Compare(tick);
    }
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
