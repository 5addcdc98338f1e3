#include "device/modbus/frame.h"

#include <algorithm>

namespace mwidth::device::modbus {
namespace {

constexpr uint8_t kReadHoldingRegisters = 3;
constexpr uint8_t kWriteMultipleRegisters = 16;
constexpr uint8_t kReadWriteMultipleRegisters = 23;
constexpr uint8_t kExceptionBit = 0x80;

void Append(Request& request, uint8_t byte) noexcept { request.bytes[request.size++] = byte; }

void Append16(Request& request, uint16_t word) noexcept {
  Append(request, static_cast<uint8_t>(word >> 8));
  Append(request, static_cast<uint8_t>(word & 0xFF));
}

void AppendValues(Request& request, std::span<const uint16_t> values) noexcept {
  Append16(request, static_cast<uint16_t>(values.size()));
  Append(request, static_cast<uint8_t>(2 * values.size()));
  for (const uint16_t value : values) {
    Append16(request, value);
  }
}

uint16_t Word(std::span<const uint8_t> bytes, std::size_t at) noexcept {
  return static_cast<uint16_t>(bytes[at] << 8 | bytes[at + 1]);
}

// An acknowledged write repeats its address and count.
bool Acknowledges(const Request& request, std::span<const uint8_t> pdu) noexcept {
  constexpr std::size_t kBytes = 5;
  return pdu.size() == kBytes && std::equal(pdu.begin(), pdu.end(), request.bytes.begin());
}

}  // namespace

Request ReadRegisters(uint16_t address, std::size_t count) noexcept {
  Request request;
  Append(request, kReadHoldingRegisters);
  Append16(request, address);
  Append16(request, static_cast<uint16_t>(count));
  request.values = count;
  return request;
}

Request WriteRegisters(uint16_t address, std::span<const uint16_t> values) noexcept {
  Request request;
  Append(request, kWriteMultipleRegisters);
  Append16(request, address);
  AppendValues(request, values);
  return request;
}

Request ReadWriteRegisters(uint16_t read_address, std::size_t read_count, uint16_t write_address,
                           std::span<const uint16_t> values) noexcept {
  Request request;
  Append(request, kReadWriteMultipleRegisters);
  Append16(request, read_address);
  Append16(request, static_cast<uint16_t>(read_count));
  Append16(request, write_address);
  AppendValues(request, values);
  request.values = read_count;
  return request;
}

Reply ParseReply(const Request& request, std::span<const uint8_t> pdu, std::span<uint16_t> values) noexcept {
  constexpr std::size_t kExceptionBytes = 2;
  if (pdu.empty()) {
    return {};
  }
  const uint8_t function = request.bytes[0];
  if (pdu[0] == (function | kExceptionBit)) {
    return pdu.size() == kExceptionBytes ? Reply{.kind = ReplyKind::kException, .exception = pdu[1]}
                                         : Reply{};
  }
  if (pdu[0] != function) {
    return {};
  }
  if (request.values == 0) {
    return {.kind = Acknowledges(request, pdu) ? ReplyKind::kAnswer : ReplyKind::kMalformed};
  }
  const std::size_t bytes = 2 * request.values;
  if (pdu.size() != 2 + bytes || pdu[1] != bytes || values.size() < request.values) {
    return {};
  }
  for (std::size_t i = 0; i < request.values; ++i) {
    values[i] = Word(pdu, 2 + 2 * i);
  }
  return {.kind = ReplyKind::kAnswer};
}

std::size_t WrapTcp(const Request& request, uint16_t transaction, uint8_t unit,
                    std::array<uint8_t, kMaxTcpBytes>& frame) noexcept {
  const auto length = static_cast<uint16_t>(request.size + 1);
  frame[0] = static_cast<uint8_t>(transaction >> 8);
  frame[1] = static_cast<uint8_t>(transaction & 0xFF);
  frame[2] = 0;
  frame[3] = 0;
  frame[4] = static_cast<uint8_t>(length >> 8);
  frame[5] = static_cast<uint8_t>(length & 0xFF);
  frame[6] = unit;
  std::copy_n(request.bytes.begin(), request.size, frame.begin() + kTcpHeaderBytes);
  return kTcpHeaderBytes + request.size;
}

Reply ParseTcpReply(const Request& request, uint16_t transaction, uint8_t unit,
                    std::span<const uint8_t> frame, std::span<uint16_t> values) noexcept {
  // Length counts from the unit on.
  constexpr std::size_t kBeforeUnit = 6;
  if (frame.size() <= kTcpHeaderBytes || Word(frame, 2) != 0 ||
      Word(frame, 4) != frame.size() - kBeforeUnit) {
    return {};
  }
  if (Word(frame, 0) != transaction) {
    return {.kind = ReplyKind::kOtherTransaction};
  }
  if (frame[kBeforeUnit] != unit) {
    return {.kind = ReplyKind::kOtherUnit};
  }
  return ParseReply(request, frame.subspan(kTcpHeaderBytes), values);
}

}  // namespace mwidth::device::modbus
