// A loop of a link's library alone: what the link gives whoever only reads a position and writes a force each
// tick.
//
//   mwidth_bare_link modbus HOST:PORT|DEVICE RATE_HZ SECONDS       libmodbus
//   mwidth_bare_link socketcand HOST:PORT RATE_HZ SECONDS          Boost.Asio; a server has set the drive up
//   before
//
// Prints JSON: ticks, missed_ticks, io_p50_s, io_p99_s.
#include <modbus/modbus.h>

#include <algorithm>
#include <array>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/streambuf.hpp>
#include <boost/asio/write.hpp>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "server/exchange/clock.h"
#include "server/render/realtime.h"

namespace mwidth::bench {
namespace {

namespace asio = boost::asio;

/// Of deploy/config/modbus.toml.
class BareModbus {
 public:
  explicit BareModbus(const std::string& address)
      : context_(address.starts_with('/')
                     ? modbus_new_rtu(address.c_str(), 115'200, 'N', 8, 1)
                     : modbus_new_tcp(address.substr(0, address.rfind(':')).c_str(),
                                      std::stoi(address.substr(address.rfind(':') + 1)))) {
    Check(context_ == nullptr ? -1 : modbus_set_slave(context_.get(), 1));
    Check(modbus_connect(context_.get()));
  }

  void Exchange() {
    constexpr int kPosition = 100;
    constexpr int kForce = 200;
    std::array<uint16_t, 2> position{};
    Check(modbus_read_registers(context_.get(), kPosition, 2, position.data()));
    Check(modbus_write_register(context_.get(), kForce, 0));
  }

 private:
  struct Free {
    void operator()(modbus_t* context) const {
      modbus_close(context);
      modbus_free(context);
    }
  };

  static void Check(int result) {
    if (result < 0) {
      throw std::runtime_error(modbus_strerror(errno));
    }
  }

  std::unique_ptr<modbus_t, Free> context_;
};

/// Of deploy/config/canopen.toml: node 1.
class BareSocketcand {
 public:
  explicit BareSocketcand(const std::string& address) : socket_(context_) {
    asio::ip::tcp::resolver resolver(context_);
    const std::size_t colon = address.rfind(':');
    asio::connect(socket_, resolver.resolve(address.substr(0, colon), address.substr(colon + 1)));
    socket_.set_option(asio::ip::tcp::no_delay(true));
    Await("< hi >");
    Send("< open can0 >");
    Await("< ok >");
    Send("< rawmode >");
    Await("< ok >");
    Send("< send 0 2 1 1 >");  // start the node
  }

  // SYNC, the TPDO that answers it, and an RPDO that keeps the motor off.
  void Exchange() {
    Send("< send 80 0 >");
    Await("< frame 181 ");
    Send("< send 201 4 6 0 0 0 >");
  }

 private:
  void Send(std::string_view line) { asio::write(socket_, asio::buffer(line)); }

  void Await(std::string_view begin) {
    while (true) {
      const std::size_t size = asio::read_until(socket_, buffer_, '>');
      std::string line(size, ' ');
      buffer_.sgetn(line.data(), static_cast<std::streamsize>(size));
      if (line.find(begin) != std::string::npos) {
        return;
      }
    }
  }

  asio::io_context context_;
  asio::ip::tcp::socket socket_;
  asio::streambuf buffer_;
};

double PercentileS(std::vector<int64_t>& times_ns, double fraction) {
  const auto nth = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(times_ns.size()));
  std::nth_element(times_ns.begin(), times_ns.begin() + nth, times_ns.end());
  return 1e-9 * static_cast<double>(times_ns[static_cast<std::size_t>(nth)]);
}

template <typename Link>
void Run(Link&& link, double rate_hz, double seconds) {
  const auto period_ns = static_cast<int64_t>(1e9 / rate_hz);
  const auto ticks = static_cast<std::size_t>(seconds * rate_hz);
  std::vector<int64_t> io_ns;
  io_ns.reserve(ticks);
  exchange::MonotonicClock clock(0);
  render::EnterRealtime({.priority = 80});
  int64_t missed = 0;
  int64_t deadline_ns = clock.NowNs() + period_ns;
  while (io_ns.size() < ticks) {
    clock.SleepUntilNs(deadline_ns);
    const int64_t begin_ns = clock.NowNs();
    link.Exchange();
    const int64_t end_ns = clock.NowNs();
    io_ns.push_back(end_ns - begin_ns);
    // As render::Loop counts them: deadlines that had passed when the next tick could begin.
    const int64_t late = std::max<int64_t>(0, end_ns - deadline_ns) / period_ns;
    missed += late;
    deadline_ns += (late + 1) * period_ns;
  }
  std::printf(R"({"ticks": %zu, "missed_ticks": %lld, "io_p50_s": %g, "io_p99_s": %g})"
              "\n",
              ticks, static_cast<long long>(missed), PercentileS(io_ns, 0.5), PercentileS(io_ns, 0.99));
}

}  // namespace
}  // namespace mwidth::bench

int main(int argc, char** argv) {
  namespace bench = mwidth::bench;
  try {
    const std::string link = argc == 5 ? argv[1] : "";
    if (link != "modbus" && link != "socketcand") {
      std::fprintf(stderr, "usage: %s modbus|socketcand ADDRESS RATE_HZ SECONDS\n", argv[0]);
      return 2;
    }
    const double rate_hz = std::atof(argv[3]);
    const double seconds = std::atof(argv[4]);
    if (link == "modbus") {
      bench::Run(bench::BareModbus(argv[2]), rate_hz, seconds);
    } else {
      bench::Run(bench::BareSocketcand(argv[2]), rate_hz, seconds);
    }
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
