#include "device/can/socket_can_bus.h"

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "device/can/wait.h"

namespace mwidth::device::can {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

// Frames of no use that one wait passes over when its time is up: a flood must not hold the loop.
constexpr int kMostPassedOver = 64;

can_frame ToKernel(const Frame& frame) noexcept {
  can_frame raw{};
  raw.can_id = frame.identifier | (frame.remote ? CAN_RTR_FLAG : 0U);
  raw.can_dlc = frame.size;
  std::copy_n(frame.bytes.begin(), kMaxFrameBytes, static_cast<uint8_t*>(raw.data));
  return raw;
}

Frame FromKernel(const can_frame& raw) noexcept {
  Frame frame{.identifier = static_cast<uint16_t>(raw.can_id & CAN_SFF_MASK),
              .remote = (raw.can_id & CAN_RTR_FLAG) != 0,
              .size = static_cast<uint8_t>(std::min<std::size_t>(raw.can_dlc, kMaxFrameBytes))};
  if (!frame.remote) {
    std::copy_n(static_cast<const uint8_t*>(raw.data), frame.size, frame.bytes.begin());
  }
  return frame;
}

bool IsUp(int file, const std::string& interface) {
  ifreq request{};
  interface.copy(static_cast<char*>(request.ifr_name), IFNAMSIZ - 1);
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-vararg): the only way to ask
  return ioctl(file, SIOCGIFFLAGS, &request) == 0 && (request.ifr_flags & IFF_UP) != 0;
}

template <typename Value>
void SetOption(int file, int option, Value value) {
  setsockopt(file, SOL_CAN_RAW, option, &value, sizeof value);
}

}  // namespace

SocketCanBus::SocketCanBus(SocketCan config) : config_(std::move(config)) {}

void SocketCanBus::Connect() {
  error_code error;
  socket_.close(error);
  joined_ = false;
  const auto fail = [this](const std::string& reason, const std::string& remedy) {
    throw std::runtime_error("CAN interface " + config_.interface + ": " + reason + "; " + remedy);
  };
  if (socket_.open(asio::generic::raw_protocol(PF_CAN, CAN_RAW), error)) {
    fail("this kernel speaks no CAN (" + error.message() + ")",
         "load the module can_raw, or use the controller of another host: type = \"socketcand\"");
  }
  const std::string bring_up = "ip link set " + config_.interface + " up type can bitrate 1000000";
  const unsigned index = if_nametoindex(config_.interface.c_str());
  if (index == 0) {
    fail("there is none of this name", "ip link shows which there are; bring one up with: " + bring_up);
  }
  const int file = socket_.native_handle();
  if (!IsUp(file, config_.interface)) {
    fail("it is down", "bring it up with: " + bring_up);
  }
  SetOption(file, CAN_RAW_RECV_OWN_MSGS, int{0});
  SetOption(file, CAN_RAW_ERR_FILTER, can_err_mask_t{CAN_ERR_BUSOFF | CAN_ERR_CRTL | CAN_ERR_TX_TIMEOUT});
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(index);
  if (socket_.bind(asio::generic::raw_protocol::endpoint(&address, sizeof address, CAN_RAW), error)) {
    fail(error.message(), "check that this user may use it");
  }
  socket_.non_blocking(true);
  joined_ = true;
}

Reception SocketCanBus::Lost() noexcept {
  joined_ = false;
  ++counters_.lost;
  return Reception::kLost;
}

bool SocketCanBus::Send(const Frame& frame) noexcept {
  const can_frame raw = ToKernel(frame);
  error_code error;
  const bool sent = joined_ && socket_.send(asio::buffer(&raw, sizeof raw), 0, error) == sizeof raw;
  // A full queue (ENOBUFS) is that of a bus on which nobody listens: the drive's silence tells of it.
  counters_.not_sent += sent ? 0 : 1;
  return sent;
}

Reception SocketCanBus::Receive(Frame& frame, int64_t deadline_ns) noexcept {
  if (!joined_) {
    return Reception::kLost;
  }
  for (int passed_over = 0; passed_over < kMostPassedOver || NowNs() < deadline_ns;) {
    can_frame raw{};
    error_code error;
    const std::size_t size = socket_.receive(asio::buffer(&raw, sizeof raw), 0, error);
    if (error == asio::error::would_block || error == asio::error::interrupted) {
      if (!WaitToRead(socket_.native_handle(), deadline_ns)) {
        return Reception::kNothing;
      }
      ++passed_over;
      continue;
    }
    if (error) {
      return Lost();
    }
    if ((raw.can_id & CAN_ERR_FLAG) != 0) {
      ++counters_.error_frames;
      if ((raw.can_id & CAN_ERR_BUSOFF) != 0) {
        return Lost();
      }
    } else if ((raw.can_id & CAN_EFF_FLAG) != 0 || size != sizeof raw) {
      ++counters_.not_classical;
    } else {
      frame = FromKernel(raw);
      return Reception::kFrame;
    }
    ++passed_over;
  }
  return Reception::kNothing;
}

}  // namespace mwidth::device::can
