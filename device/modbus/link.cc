#include "device/modbus/link.h"

#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "device/monotonic_clock.h"

namespace mwidth::device::modbus {
namespace {

modbus_t* NewContext(const LinkConfig& config) {
  if (const auto* tcp = std::get_if<TcpAddress>(&config.peer)) {
    return modbus_new_tcp_pi(tcp->host.c_str(), std::to_string(tcp->port).c_str());
  }
  const auto& line = std::get<SerialLine>(config.peer);
  constexpr int kDataBits = 8;
  return modbus_new_rtu(line.device.c_str(), line.baud, line.parity, kDataBits, line.stop_bits);
}

// libmodbus waits with select, which would write beyond its set of descriptors.
bool FitsSelect(int file) noexcept { return file < FD_SETSIZE; }

// The lowest descriptor that is free: the next file's, unless another thread takes it. Below 0 where none is.
int NextFile() noexcept {
  const int file = open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (file >= 0) {
    close(file);
  }
  return file;
}

// What there is to do about a connection that cannot be had.
const char* Remedy(bool tcp) {
  return tcp ? "check that the drive is on, its address, and that nobody else is connected to it"
             : "check the cable, the device's name, and that this user may open it (group dialout)";
}

}  // namespace

std::string NameOf(const LinkConfig& config) {
  const auto* tcp = std::get_if<TcpAddress>(&config.peer);
  return (tcp != nullptr ? tcp->host + ":" + std::to_string(tcp->port)
                         : std::get<SerialLine>(config.peer).device) +
         " unit " + std::to_string(config.unit);
}

std::string LockNameOf(const LinkConfig& config) {
  const auto* line = std::get_if<SerialLine>(&config.peer);
  if (line == nullptr) {
    return "modbus:" + NameOf(config);
  }
  std::error_code unknown;
  const std::filesystem::path device = std::filesystem::canonical(line->device, unknown);
  return "modbus:" + (unknown ? line->device : device.string());
}

Link::Link(LinkConfig config) : config_(std::move(config)) {}

Link::~Link() { Close(); }

void Link::Connect() {
  Close();
  context_.reset(NewContext(config_));
  const auto fail = [this](const std::string& reason) {
    Close();
    throw std::runtime_error("Modbus drive at " + NameOf(config_) + ": " + reason + "; " + Remedy(IsTcp()));
  };
  if (!context_) {
    fail(modbus_strerror(errno));
  }
  if (modbus_set_slave(context_.get(), config_.unit) < 0) {
    fail("no unit has the number " + std::to_string(config_.unit));
  }
  // Bounds the attempt to connect; exchanges set their own.
  modbus_set_response_timeout(context_.get(), 1, 0);
  modbus_set_byte_timeout(context_.get(), 0, 0);
  modbus_set_error_recovery(context_.get(), MODBUS_ERROR_RECOVERY_NONE);
  constexpr const char* kTooManyFiles = "the process has too many files open";
  // Before as well: modbus_connect itself waits with select.
  if (!FitsSelect(NextFile())) {
    fail(kTooManyFiles);
  }
  if (modbus_connect(context_.get()) < 0) {
    fail(modbus_strerror(errno));
  }
  connected_ = true;
  const int file = modbus_get_socket(context_.get());
  if (!FitsSelect(file)) {
    fail(kTooManyFiles);
  }
  if (IsTcp()) {
    const int on = 1;
    setsockopt(file, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  }
  line_unsure_ = false;
}

void Link::Close() noexcept {
  if (connected_) {
    modbus_close(context_.get());
    connected_ = false;
  }
  context_.reset();
}

Outcome Link::Disconnected() noexcept {
  // The context stays for Connect to free: freeing memory is nothing for a tick.
  modbus_close(context_.get());
  connected_ = false;
  ++counters_.disconnects;
  return Outcome::kDisconnected;
}

Outcome Link::Exchange(const Request& request, std::span<uint16_t> values, int64_t deadline_ns) noexcept {
  if (!connected_) {
    return Outcome::kDisconnected;
  }
  // Behind a whole reply nothing is left on a connection but duplicates, which their number betrays.
  if ((line_unsure_ || !IsTcp()) && !Discard()) {
    return Disconnected();
  }
  if (std::exchange(line_unsure_, false) && !IsTcp()) {
    ++counters_.silent;
    return Outcome::kSilent;
  }
  if (!Send(request)) {
    return Disconnected();
  }
  const Outcome outcome = Receive(request, values, deadline_ns);
  line_unsure_ = outcome == Outcome::kSilent || outcome == Outcome::kMalformed;
  return outcome;
}

// False where the connection is gone, or so flooded that it is no use. modbus_flush would go on for as long
// as the flood does.
bool Link::Discard() noexcept {
  if (!IsTcp()) {
    return modbus_flush(context_.get()) >= 0;
  }
  constexpr int kMostParts = 8;
  std::array<uint8_t, 1024> part{};
  for (int i = 0; i < kMostParts; ++i) {
    const ssize_t size = recv(modbus_get_socket(context_.get()), part.data(), part.size(), MSG_DONTWAIT);
    if (size < 0) {
      return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
    }
    if (size == 0) {
      return false;
    }
  }
  return false;
}

bool Link::Send(const Request& request) noexcept {
  if (IsTcp()) {
    std::array<uint8_t, kMaxTcpBytes> frame{};
    const std::size_t size = WrapTcp(request, ++transaction_, config_.unit, frame);
    // A request that does not fit into the socket's buffer at once means that nothing has been taken for
    // long.
    return send(modbus_get_socket(context_.get()), frame.data(), size, MSG_NOSIGNAL | MSG_DONTWAIT) ==
           static_cast<ssize_t>(size);
  }
  std::array<uint8_t, kMaxPduBytes + 1> frame{};
  frame[0] = config_.unit;
  std::copy_n(request.bytes.begin(), request.size, frame.begin() + 1);
  return modbus_send_raw_request(context_.get(), frame.data(), static_cast<int>(request.size + 1)) > 0;
}

Reply Link::Judge(const Request& request, std::span<const uint8_t> frame,
                  std::span<uint16_t> values) const noexcept {
  if (IsTcp()) {
    return ParseTcpReply(request, transaction_, config_.unit, frame, values);
  }
  // Unit, protocol data unit, and the checksum that libmodbus has checked.
  constexpr std::size_t kUnitBytes = 1;
  constexpr std::size_t kChecksumBytes = 2;
  if (frame.empty() || frame[0] != config_.unit) {
    return {.kind = ReplyKind::kOtherUnit};
  }
  if (frame.size() < kUnitBytes + kChecksumBytes) {
    return {};
  }
  return ParseReply(request, frame.subspan(kUnitBytes, frame.size() - kUnitBytes - kChecksumBytes), values);
}

Outcome Link::Receive(const Request& request, std::span<uint16_t> values, int64_t deadline_ns) noexcept {
  std::array<uint8_t, MODBUS_MAX_ADU_LENGTH> frame{};
  while (true) {
    const int64_t left_us = (deadline_ns - NowNs()) / 1000;
    if (left_us <= 0) {
      ++counters_.silent;
      return Outcome::kSilent;
    }
    constexpr int64_t kMicrosecondsInASecond = 1'000'000;
    modbus_set_response_timeout(context_.get(), static_cast<uint32_t>(left_us / kMicrosecondsInASecond),
                                static_cast<uint32_t>(left_us % kMicrosecondsInASecond));
    const int size = modbus_receive_confirmation(context_.get(), frame.data());
    if (size < 0) {
      return ReceiveFailed(errno);
    }
    switch (Judge(request, {frame.data(), static_cast<std::size_t>(size)}, values).kind) {
      case ReplyKind::kAnswer:
        return Outcome::kAnswered;
      case ReplyKind::kException:
        ++counters_.exceptions;
        return Outcome::kException;
      case ReplyKind::kMalformed:
        ++counters_.malformed;
        return Outcome::kMalformed;
      case ReplyKind::kOtherTransaction:
        ++counters_.other_transaction;
        break;
      case ReplyKind::kOtherUnit:
        ++counters_.other_unit;
        break;
    }
  }
}

Outcome Link::ReceiveFailed(int error) noexcept {
  if (error == ETIMEDOUT) {
    ++counters_.silent;
    return Outcome::kSilent;
  }
  if (error == EMBBADDATA || error == EMBBADCRC || error == EMBBADEXC) {
    ++counters_.malformed;
    return Outcome::kMalformed;
  }
  return Disconnected();
}

}  // namespace mwidth::device::modbus
