// A loop of libmodbus alone: what a link gives whoever only reads a position and writes a force each tick.
//
//   mwidth_bare_modbus HOST:PORT | DEVICE  RATE_HZ SECONDS      prints JSON: ticks, missed_ticks, io_p50_s,
//   io_p99_s
#include <modbus/modbus.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "server/exchange/clock.h"
#include "server/render/realtime.h"

namespace mwidth::bench {
namespace {

// Of deploy/config/modbus.toml.
constexpr int kPosition = 100;
constexpr int kForce = 200;
constexpr int kBaud = 115'200;

struct Free {
  void operator()(modbus_t* context) const {
    modbus_close(context);
    modbus_free(context);
  }
};
using Context = std::unique_ptr<modbus_t, Free>;

Context Connect(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  Context context(address.starts_with('/') ? modbus_new_rtu(address.c_str(), kBaud, 'N', 8, 1)
                                           : modbus_new_tcp(address.substr(0, colon).c_str(),
                                                            std::stoi(address.substr(colon + 1))));
  if (context == nullptr || modbus_set_slave(context.get(), 1) != 0 || modbus_connect(context.get()) != 0) {
    throw std::runtime_error(address + ": " + modbus_strerror(errno));
  }
  return context;
}

double PercentileS(std::vector<int64_t>& times_ns, double fraction) {
  const auto nth = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(times_ns.size()));
  std::nth_element(times_ns.begin(), times_ns.begin() + nth, times_ns.end());
  return 1e-9 * static_cast<double>(times_ns[static_cast<std::size_t>(nth)]);
}

void Run(const std::string& address, double rate_hz, double seconds) {
  const Context context = Connect(address);
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
    std::array<uint16_t, 2> position{};
    if (modbus_read_registers(context.get(), kPosition, 2, position.data()) < 0 ||
        modbus_write_register(context.get(), kForce, 0) < 0) {
      throw std::runtime_error(address + ": " + modbus_strerror(errno));
    }
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
  try {
    if (argc != 4) {
      std::fprintf(stderr, "usage: %s HOST:PORT|DEVICE RATE_HZ SECONDS\n", argv[0]);
      return 2;
    }
    mwidth::bench::Run(argv[1], std::atof(argv[2]), std::atof(argv[3]));
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
