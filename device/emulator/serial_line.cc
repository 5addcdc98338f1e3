#include "device/emulator/serial_line.h"

#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <boost/asio/serial_port_base.hpp>
#include <cerrno>
#include <cstdlib>
#include <system_error>

namespace mwidth::device::emulator {
namespace {

using Port = boost::asio::serial_port_base;

Port::parity ParityOf(char parity) {
  switch (parity) {
    case 'E':
      return Port::parity(Port::parity::even);
    case 'O':
      return Port::parity(Port::parity::odd);
    default:
      return Port::parity(Port::parity::none);
  }
}

}  // namespace

boost::asio::serial_port OpenSerialPort(boost::asio::io_context& context, const std::string& device,
                                        const modbus::SerialLine& line) {
  boost::asio::serial_port port(context, device);
  port.set_option(Port::baud_rate(static_cast<unsigned>(line.baud)));
  port.set_option(Port::character_size(8));
  port.set_option(ParityOf(line.parity));
  port.set_option(Port::stop_bits(line.stop_bits == 2 ? Port::stop_bits::two : Port::stop_bits::one));
  port.set_option(Port::flow_control(Port::flow_control::none));
  return port;
}

PseudoTerminal::PseudoTerminal(boost::asio::io_context& context) : line_(context) {
  const auto check = [](bool well, const char* what) {
    if (!well) {
      throw std::system_error(errno, std::generic_category(), what);
    }
  };
  const int master = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  check(master >= 0, "pseudo-terminal");
  line_.assign(master);
  check(grantpt(master) == 0 && unlockpt(master) == 0, "pseudo-terminal");
  constexpr std::size_t kPathBytes = 64;
  std::array<char, kPathBytes> path{};
  check(ptsname_r(master, path.data(), path.size()) == 0, "pseudo-terminal");
  path_ = path.data();
  other_end_ = open(path_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  check(other_end_ >= 0, path.data());
  // Bytes as they are: no echo, no lines.
  termios raw{};
  check(tcgetattr(other_end_, &raw) == 0, path.data());
  cfmakeraw(&raw);
  check(tcsetattr(other_end_, TCSANOW, &raw) == 0, path.data());
}

PseudoTerminal::~PseudoTerminal() { close(other_end_); }

std::chrono::microseconds RtuSilence(int baud) {
  constexpr int kFast = 19'200;
  constexpr std::chrono::microseconds kFixed{1750};
  // 3.5 characters of 11 bits.
  constexpr double kBits = 38.5;
  return baud > kFast ? kFixed : std::chrono::microseconds(static_cast<int64_t>(kBits * 1e6 / baud));
}

}  // namespace mwidth::device::emulator
