// A CiA 402 drive on CANopen, in cyclic synchronous torque mode.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "device/can/bus.h"
#include "device/canopen/arming.h"
#include "device/canopen/canopen_drive_config.h"
#include "device/canopen/process_data.h"
#include "device/canopen/sdo_client.h"
#include "device/drive.h"
#include "device/drive_lock.h"
#include "device/monotonic_clock.h"
#include "device/reconnection.h"

namespace mwidth::device::canopen {

/// What a server holds while it has the drive, so that no other one of this host takes it.
std::string LockNameOf(const CanopenDriveConfig& config);

/// The loop's thread exchanges process data, and sends our heartbeat: where the loop is dead, the drive hears
/// none. A connection that is lost, and a drive that has booted anew, are set up again by a thread of their
/// own. All Rt but the constructors, the destructor and what says so.
class CanopenDrive final : public Drive {
 public:
  /// Joins the bus and sets the drive up. Throws std::runtime_error, with what to do, where that fails.
  explicit CanopenDrive(const CanopenDriveConfig& config);
  /// The same on this bus, at this time: for tests.
  CanopenDrive(const CanopenDriveConfig& config, std::unique_ptr<can::Bus> bus, Now now);
  CanopenDrive(const CanopenDrive&) = delete;
  CanopenDrive& operator=(const CanopenDrive&) = delete;
  /// Takes the force away, as far as the drive still listens.
  ~CanopenDrive() override;

  DriveInfo Info() const noexcept override;
  /// One step on the way to "operation enabled" with every call, a call a tick.
  Enabling Enable() noexcept override;
  /// Disables the voltage: the motor is let go of, not braked.
  void Disable() noexcept override;
  Reading Read(uint64_t tick) noexcept override;
  bool Write(int32_t force_counts) noexcept override;

  /// What came and was not used. The loop's thread.
  const NodeCounters& counters() const noexcept { return data_.watch().counters; }

 private:
  bool HeardForeign(int64_t since_ns) const noexcept;
  /// The drive has booted anew, or sends no heartbeat any more.
  bool IsGone() const noexcept;
  /// Leaves the drive to the thread that sets it up anew.
  void HandOver() noexcept;
  Reading WithTrouble(Reading reading) const noexcept;
  /// Whether the drive has let go of the motor since it was told to; says it again, without our heartbeat,
  /// until it has.
  void WatchRelease() noexcept;
  /// Not Rt.
  void Connect();

  const DriveLock lock_;
  const CanopenDriveConfig config_;
  const Now now_;
  // Whoever has the link, by reconnection_.
  const std::unique_ptr<can::Bus> bus_;
  ProcessData data_{*bus_, config_, now_};
  Arming arming_{config_};
  bool enabled_ = false;
  int64_t enabled_ns_ = 0;
  // The drive has said that it makes no force, since it was last told to make none.
  bool released_ = false;

  Reconnection reconnection_{[this] { Connect(); }};
};

}  // namespace mwidth::device::canopen
