// Modbus requests and replies as bytes (Modbus Application Protocol Specification V1.1b3). Pure; every
// function is Rt.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace mwidth::device::modbus {

/// Largest protocol data unit: function code and data.
inline constexpr std::size_t kMaxPduBytes = 253;
/// Modbus TCP: transaction, protocol, length, unit.
inline constexpr std::size_t kTcpHeaderBytes = 7;
inline constexpr std::size_t kMaxTcpBytes = kTcpHeaderBytes + kMaxPduBytes;
/// Most registers that one request may read or write here: far below what the protocol allows, and more than
/// a drive is asked for.
inline constexpr std::size_t kMaxRegisters = 32;

/// Function code and data of a request.
struct Request {
  std::array<uint8_t, kMaxPduBytes> bytes{};
  std::size_t size = 0;
  /// Registers that the reply brings.
  std::size_t values = 0;

  std::span<const uint8_t> pdu() const noexcept { return {bytes.data(), size}; }
};

/// `count` holding registers from `address` (function 3); 1 to kMaxRegisters.
Request ReadRegisters(uint16_t address, std::size_t count) noexcept;
/// Writes `values` from `address` on (function 16); 1 to kMaxRegisters.
Request WriteRegisters(uint16_t address, std::span<const uint16_t> values) noexcept;
/// Writes first, then reads, in one request (function 23).
Request ReadWriteRegisters(uint16_t read_address, std::size_t read_count, uint16_t write_address,
                           std::span<const uint16_t> values) noexcept;

/// What a frame turned out to be.
enum class ReplyKind : uint8_t {
  kAnswer,
  /// The drive refused: see Reply::exception.
  kException,
  /// It answers an earlier request: late, or a duplicate.
  kOtherTransaction,
  /// It comes from, or is meant for, another unit.
  kOtherUnit,
  /// It is no answer to this request: another function, a lying or impossible length.
  kMalformed,
};

struct Reply {
  ReplyKind kind = ReplyKind::kMalformed;
  /// Exception code of the drive; 0 where there is none.
  uint8_t exception = 0;
};

/// Judges the protocol data unit of a reply and copies its registers into `values`, which holds
/// `request.values` or more. Leaves them alone unless the reply is an answer.
Reply ParseReply(const Request& request, std::span<const uint8_t> pdu, std::span<uint16_t> values) noexcept;

/// A request as Modbus TCP sends it; returns how many bytes of `frame` it takes.
std::size_t WrapTcp(const Request& request, uint16_t transaction, uint8_t unit,
                    std::array<uint8_t, kMaxTcpBytes>& frame) noexcept;
/// ParseReply for a whole Modbus TCP frame: transaction, protocol, length and unit are checked first.
Reply ParseTcpReply(const Request& request, uint16_t transaction, uint8_t unit,
                    std::span<const uint8_t> frame, std::span<uint16_t> values) noexcept;

}  // namespace mwidth::device::modbus
