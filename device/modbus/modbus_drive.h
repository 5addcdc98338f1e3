// A drive behind Modbus TCP or RTU.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "device/drive.h"
#include "device/drive_lock.h"
#include "device/modbus/link.h"
#include "device/modbus/modbus_drive_config.h"
#include "device/monotonic_clock.h"
#include "device/reconnection.h"

namespace mwidth::device::modbus {

/// The loop's thread exchanges with the drive; a connection that is lost is made again by a thread of its
/// own, which also takes the force away before it hands the drive back. All Rt but the constructor, the
/// destructor and what says so.
class ModbusDrive final : public Drive {
 public:
  /// Connects and takes the force away. Throws std::runtime_error, with what to do, where the drive does not
  /// answer.
  explicit ModbusDrive(const ModbusDriveConfig& config);
  /// The same, with its silences (see Read) counted at this time: for tests. Replies have CLOCK_MONOTONIC.
  ModbusDrive(const ModbusDriveConfig& config, Now now);
  ModbusDrive(const ModbusDrive&) = delete;
  ModbusDrive& operator=(const ModbusDrive&) = delete;
  /// Takes the force away, as far as the drive still answers.
  ~ModbusDrive() override;

  DriveInfo Info() const noexcept override;
  /// Reads the watchdog back, writes a force of zero, then the enable register: up to four exchanges, and
  /// Disable() behind one that failed. kSilent, and nothing is sent, while the drive may hold a force (see
  /// Read).
  Enabling Enable() noexcept override;
  /// Writes a force of zero and the disabling word, whether enabled or not: two exchanges.
  void Disable() noexcept override;
  /// Where the drive has acknowledged neither a force of zero nor the disabling word since it was last
  /// enabled, or since that failed, it may hold a force: then nothing is sent for 1.5 kMaxWatchdogS, so that
  /// its own watchdog fires, then Disable() once more; no reading is ok until one is acknowledged.
  Reading Read(uint64_t tick) noexcept override;
  /// False, and nothing is sent, while not enabled.
  bool Write(int32_t force_counts) noexcept override;

  /// What came and was not used. The loop's thread.
  const LinkCounters& counters() const noexcept { return link_.counters(); }

 private:
  using Words = std::array<uint16_t, kMaxValueRegisters>;

  /// A force may act that nobody commands. Only where there is a link.
  bool MayHoldForce() const noexcept { return !enabled_ && !force_away_; }
  /// One request of the tick; hands a lost connection to the thread that makes it anew.
  Outcome Ask(const Request& request, std::span<uint16_t> words) noexcept;
  Outcome Put(uint16_t address, std::span<const uint16_t> words) noexcept;
  Outcome PutForce(int32_t force_counts) noexcept;
  Outcome PutEnabled(bool enabled) noexcept;
  Enabling Arm() noexcept;
  Enabling CheckWatchdog() noexcept;
  Words ForceWords(int32_t force_counts) const noexcept;
  Reading PositionOf(std::span<const uint16_t> words) const noexcept;
  /// Not Rt.
  void Connect();
  void TakeForceAway();

  const DriveLock lock_;
  const ModbusDriveConfig config_;
  const DriveInfo info_;
  const Now now_;
  // Whoever has the link, by reconnection_.
  Link link_;
  bool enabled_ = false;
  bool arming_ = false;
  bool answered_ = false;
  // The drive has acknowledged, since it was last to be enabled, what takes the force away.
  bool force_away_ = false;
  int32_t force_counts_ = 0;
  // The loop's thread alone.
  int64_t silent_until_ns_ = 0;

  Reconnection reconnection_{[this] { Connect(); }};
};

}  // namespace mwidth::device::modbus
