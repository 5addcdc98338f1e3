// A drive behind a stopwatch: what the calls of one tick took.
#pragma once

#include <cstdint>
#include <optional>

#include "device/drive.h"
#include "server/exchange/clock.h"

namespace mwidth::render {

/// What the drive's calls took since they were last asked about.
struct DriveTimes {
  int64_t io_ns = 0;
  /// From before the last read that was answered to after the last write that was taken; none where either is
  /// missing.
  std::optional<int64_t> loop_delay_ns;
};

/// Passes every call on and measures it, so that the tick itself need not know the time. The loop's thread;
/// all but the constructor is Rt.
class TimedDrive final : public device::Drive {
 public:
  /// `drive` and `clock` outlive it.
  TimedDrive(device::Drive& drive, const exchange::Clock& clock) noexcept : drive_(drive), clock_(clock) {}

  device::DriveInfo Info() const noexcept override { return drive_.Info(); }
  device::Enabling Enable() noexcept override {
    const int64_t begin_ns = clock_.NowNs();
    const device::Enabling enabled = drive_.Enable();
    times_.io_ns += clock_.NowNs() - begin_ns;
    return enabled;
  }
  void Disable() noexcept override {
    const int64_t begin_ns = clock_.NowNs();
    drive_.Disable();
    times_.io_ns += clock_.NowNs() - begin_ns;
  }
  device::Reading Read(uint64_t tick) noexcept override {
    const int64_t begin_ns = clock_.NowNs();
    const device::Reading reading = drive_.Read(tick);
    times_.io_ns += clock_.NowNs() - begin_ns;
    // The drive sampled the position no earlier than this.
    sampled_ns_ = reading.ok ? std::optional(begin_ns) : std::nullopt;
    return reading;
  }
  bool Write(int32_t force_counts) noexcept override {
    const int64_t begin_ns = clock_.NowNs();
    const bool taken = drive_.Write(force_counts);
    const int64_t end_ns = clock_.NowNs();
    times_.io_ns += end_ns - begin_ns;
    if (taken && sampled_ns_) {
      times_.loop_delay_ns = end_ns - *sampled_ns_;
    }
    return taken;
  }

  /// The times since the last call, which begin anew.
  DriveTimes TakeTimes() noexcept {
    const DriveTimes taken = times_;
    times_ = {};
    sampled_ns_.reset();
    return taken;
  }

 private:
  device::Drive& drive_;
  const exchange::Clock& clock_;
  DriveTimes times_;
  std::optional<int64_t> sampled_ns_;
};

}  // namespace mwidth::render
