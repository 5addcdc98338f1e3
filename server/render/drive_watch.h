// Whether the drive answers, and what it says of itself.
#pragma once

#include <cstdint>

#include "server/render/breach.h"
#include "server/render/loop_config.h"
#include "server/render/observation.h"
#include "server/render/time_allowance.h"

namespace mwidth::render {

/// Ticks without an answer of the drive over which the last estimate stands in for the missing one.
inline constexpr uint64_t kHeldTicks = 2;

/// What the drive reports of itself, while it is enabled. Rt.
inline Breach JudgeTrouble(const Observation& seen) noexcept {
  switch (seen.trouble) {
    case device::DriveTrouble::kNone:
      break;
    case device::DriveTrouble::kError:
      return {exchange::Fault::kDriveError, static_cast<double>(seen.trouble_code), 0};
    case device::DriveTrouble::kForeignTraffic:
      return {exchange::Fault::kForeignTraffic, static_cast<double>(seen.trouble_code), 0};
  }
  return {};
}

/// A tick is silent when the drive did not answer with a position, or did not take the force. The loop's
/// thread; all Rt. Read and Wrote are called in this order, once in every tick.
class DriveWatch {
 public:
  explicit DriveWatch(const LoopConfig& config) noexcept
      : gaps_(config.period_s, config.watch.window_s, config.watch.gap_s) {}

  void Read(bool answered, uint64_t missed_ticks) noexcept {
    missed_ticks_ = missed_ticks;
    silent_ = !answered;
    if (silent_) {
      CountSilence();
    }
    gaps_.Pass(missed_ticks, true);
  }
  /// `taken`: also where nothing was sent.
  void Wrote(bool taken) noexcept {
    if (!silent_ && taken) {
      silent_ticks_ = 0;
    } else if (!silent_) {
      silent_ = true;
      CountSilence();
    }
    gaps_.Pass(1, silent_);
  }
  /// Forgets the gaps: before there was a force they did no harm. A silence that goes on is not forgotten.
  void Begin() noexcept { gaps_.Reset(); }

  /// A silence longer than can be held, up to now.
  Breach JudgeSilence() const noexcept {
    if (silent_ && silent_ticks_ > kHeldTicks) {
      return {exchange::Fault::kDriveSilent, static_cast<double>(silent_ticks_), kHeldTicks};
    }
    return {};
  }
  /// Short gaps, of the drive or of the loop, that go on and on.
  Breach JudgeGaps() const noexcept {
    if (gaps_.Exceeded()) {
      return {exchange::Fault::kPositionGaps, gaps_.spent_s(), gaps_.allowed_s()};
    }
    return {};
  }

 private:
  // Ticks missed within a silence count as silent; those before it are the host's fault, not the drive's.
  void CountSilence() noexcept { silent_ticks_ += silent_ticks_ == 0 ? 1 : 1 + missed_ticks_; }

  TimeAllowance gaps_;
  uint64_t missed_ticks_ = 0;
  uint64_t silent_ticks_ = 0;
  bool silent_ = false;
};

}  // namespace mwidth::render
