// A connection to one Modbus unit whose every exchange ends in time.
#pragma once

#include <modbus/modbus.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "device/modbus/frame.h"
#include "device/modbus/modbus_drive_config.h"

namespace mwidth::device::modbus {

/// How an exchange ended.
enum class Outcome : uint8_t {
  kAnswered,
  /// The drive answered with an exception.
  kException,
  /// Nothing that counts came in time.
  kSilent,
  /// Something came that is no Modbus reply to what was asked.
  kMalformed,
  /// The connection is gone.
  kDisconnected,
};

/// What came and was not used, since the link was made.
struct LinkCounters {
  uint64_t exceptions = 0;
  uint64_t silent = 0;
  uint64_t malformed = 0;
  uint64_t other_transaction = 0;
  uint64_t other_unit = 0;
  uint64_t disconnects = 0;
};

/// "127.0.0.1:502 unit 1" or "/dev/ttyUSB0 unit 1".
std::string NameOf(const LinkConfig& config);
/// What a DriveLock on the drive at this link is called. A serial line is one server's, whatever unit and by
/// whatever link of the file system: the answers to two would mix.
std::string LockNameOf(const LinkConfig& config);

/// libmodbus, held to a deadline. It brings connection, framing and RTU's checksum; requests, and the
/// judgement of replies, are those of frame.h, because libmodbus looks at neither the unit of a TCP reply nor
/// the next frame behind a late one. Its error recovery stays off: that would sleep and reconnect inside of a
/// call. Its byte time-out is off as well, so that one time-out bounds the whole reply, byte by byte or not.
///
/// One thread at a time.
class Link {
 public:
  explicit Link(LinkConfig config);
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;
  ~Link();

  /// Connects anew, within about a second for each address of the host. Throws std::runtime_error, with what
  /// to do.
  void Connect();
  bool connected() const noexcept { return connected_; }

  /// Sends the request and waits for its reply, at most until `deadline_ns` of CLOCK_MONOTONIC and the few
  /// microseconds of the last system call. What had come before is passed over; so is what comes meanwhile
  /// and belongs to another request or unit. `values` takes the registers. An RTU frame bears no number:
  /// after an exchange that failed, the next one sends nothing and only lets the line fall silent, or a late
  /// reply would pass for the new one. Rt.
  Outcome Exchange(const Request& request, std::span<uint16_t> values, int64_t deadline_ns) noexcept;

  const LinkCounters& counters() const noexcept { return counters_; }

 private:
  struct Free {
    void operator()(modbus_t* context) const noexcept { modbus_free(context); }
  };

  bool IsTcp() const noexcept { return std::holds_alternative<TcpAddress>(config_.peer); }
  bool Discard() noexcept;
  bool Send(const Request& request) noexcept;
  Outcome Receive(const Request& request, std::span<uint16_t> values, int64_t deadline_ns) noexcept;
  Outcome ReceiveFailed(int error) noexcept;
  Reply Judge(const Request& request, std::span<const uint8_t> frame,
              std::span<uint16_t> values) const noexcept;
  Outcome Disconnected() noexcept;
  void Close() noexcept;

  const LinkConfig config_;
  std::unique_ptr<modbus_t, Free> context_;
  bool connected_ = false;
  bool line_unsure_ = false;
  uint16_t transaction_ = 0;
  LinkCounters counters_;
};

}  // namespace mwidth::device::modbus
