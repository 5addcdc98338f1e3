#include "device/emulator/modbus_rtu_server.h"

#include <boost/asio/buffer.hpp>
#include <optional>
#include <utility>

namespace mwidth::device::emulator {

using std::chrono::nanoseconds;
using std::chrono::steady_clock;

ModbusRtuServer::ModbusRtuServer(boost::asio::serial_port line, uint8_t unit,
                                 std::chrono::microseconds silence, ModbusRegisters& registers,
                                 const LinkFaults& faults)
    : line_(std::move(line)),
      writer_(line_, faults),
      silence_timer_(line_.get_executor()),
      unit_(unit),
      silence_(silence),
      registers_(registers) {
  Read();
}

void ModbusRtuServer::Read() {
  line_.async_read_some(boost::asio::buffer(part_), [this](auto error, std::size_t size) {
    // A line that is gone stays so: the joint's watchdog does the rest.
    if (error) {
      return;
    }
    // Whoever floods the line while an answer is under way is not listened to.
    constexpr std::size_t kMost = 16 * kMaxRtuBytes;
    if (received_.size() + size > kMost) {
      received_.clear();
    }
    received_.insert(received_.end(), part_.begin(), part_.begin() + static_cast<std::ptrdiff_t>(size));
    Next();
    Read();
  });
}

// Obeys the requests that are whole; for the rest of one waits until the silence says that there is none.
void ModbusRtuServer::Next() {
  silence_timer_.cancel();
  while (!answering_) {
    const std::optional<std::size_t> size = RtuRequestBytes(received_);
    if (!size || received_.size() < *size || !IsWholeRtuFrame(std::span(received_).first(*size))) {
      break;
    }
    const auto end = received_.begin() + static_cast<std::ptrdiff_t>(*size);
    const std::vector<uint8_t> frame(received_.begin(), end);
    received_.erase(received_.begin(), end);
    Obey(frame);
  }
  if (!answering_ && !received_.empty()) {
    AwaitSilence();
  }
}

void ModbusRtuServer::AwaitSilence() {
  silence_timer_.expires_after(silence_);
  silence_timer_.async_wait([this](auto error) {
    if (!error) {
      EndFrame();
    }
  });
}

void ModbusRtuServer::EndFrame() {
  const std::vector<uint8_t> frame = std::exchange(received_, {});
  // A function that nobody knows says no length; its exception is due all the same.
  if (!RtuRequestBytes(frame) && IsWholeRtuFrame(frame)) {
    Obey(frame);
  }
}

void ModbusRtuServer::Obey(std::span<const uint8_t> frame) {
  constexpr uint8_t kEverybody = 0;
  if (frame[0] != unit_ && frame[0] != kEverybody) {
    return;
  }
  constexpr std::size_t kUnitAndChecksum = 3;
  const int64_t now_ns = steady_clock::now().time_since_epoch() / nanoseconds(1);
  const std::vector<uint8_t> pdu =
      registers_.Answer(frame.subspan(1, frame.size() - kUnitAndChecksum), now_ns);
  // A request to everybody is obeyed by everybody, who would all answer at once.
  if (pdu.empty() || frame[0] == kEverybody) {
    return;
  }
  answering_ = true;
  writer_.Write(RtuFrame(unit_, pdu), [this] {
    answering_ = false;
    Next();
  });
}

}  // namespace mwidth::device::emulator
