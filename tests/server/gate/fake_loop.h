// A loop without mathematics or drive that keeps the contract of exchange/crossing.h, one tick at a time.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "server/exchange/clock.h"
#include "server/exchange/crossing.h"

namespace mwidth::gate {

class FakeClock final : public exchange::Clock {
 public:
  int64_t NowNs() const noexcept override { return now_ns_.fetch_add(step_ns_.exchange(0)); }
  void SleepUntilNs(int64_t deadline_ns) noexcept override { now_ns_ = deadline_ns; }
  void AdvanceS(double seconds) { now_ns_ += static_cast<int64_t>(seconds * 1e9); }
  /// Lets that much time pass right after somebody looks at the clock next.
  void AdvanceAfterNextLookS(double seconds) { step_ns_ = static_cast<int64_t>(seconds * 1e9); }

 private:
  // Far from 0, as a monotonic clock is.
  mutable std::atomic<int64_t> now_ns_{5'000'000'000};
  mutable std::atomic<int64_t> step_ns_{0};
};

/// Not thread-safe: tick it from the test or from one thread.
class FakeLoop {
 public:
  /// How many ticks the ramp to zero of an ending takes.
  static constexpr int kEndTicks = 3;

  FakeLoop(exchange::Crossing& crossing, const exchange::Clock& clock) : crossing_(crossing), clock_(clock) {}

  void Tick() {
    ++status_.tick;
    status_.monotonic_ns = clock_.NowNs();
    crossing_.settings.Take(settings_);
    status_.settings_sequence = settings_.sequence;
    if (settings_.emergency_stops > emergency_stops_seen_) {
      emergency_stops_seen_ = settings_.emergency_stops;
      Trip(exchange::Fault::kEmergencyStop);
    }
    Obey();
    if (status_.mass == 0 && filter_ticks_-- <= 0) {
      status_.filter = settings_.filter;
    }
    crossing_.status.Post(status_);
  }

  void Trip(exchange::Fault fault) {
    if (status_.state == exchange::State::kRendering) {
      ++status_.renderings_ended;
    }
    status_.state = exchange::State::kFault;
    status_.mass = 0;
    status_.target_mass = 0;
    status_.fault = {.fault = fault, .number = status_.fault.number + 1, .tick = status_.tick};
  }

  /// From now on the drive cannot be enabled.
  void RefuseDrive() { drive_refuses_ = true; }
  /// Ticks that a cleared fault stays latched, as while its ramp goes on.
  void HoldFaults(int ticks) { fault_ticks_ = ticks; }
  /// Ticks that a change of filter takes, with no mass rendered.
  void HoldFilter(int ticks) { filter_ticks_ = ticks; }
  /// From now on a start is acknowledged and not obeyed.
  void IgnoreStarts() { ignores_starts_ = true; }

  const exchange::LoopStatus& status() const { return status_; }
  const exchange::Settings& settings() const { return settings_; }

 private:
  void Obey() {
    const bool wanted = settings_.rendering && clock_.NowNs() < settings_.lease_deadline_ns;
    const bool may_begin =
        status_.state == exchange::State::kIdle || status_.state == exchange::State::kReady;
    if (status_.state == exchange::State::kFault) {
      if (settings_.cleared_fault_number >= status_.fault.number && fault_ticks_-- <= 0) {
        status_.state = exchange::State::kIdle;
        status_.fault = {.number = status_.fault.number};
      }
    } else if (may_begin && wanted && settings_.render_epoch > epoch_seen_ && !ignores_starts_) {
      Begin();
    } else if (status_.state == exchange::State::kRendering) {
      Render(wanted);
    }
    epoch_seen_ = std::max(epoch_seen_, settings_.render_epoch);
  }

  void Begin() {
    if (drive_refuses_) {
      Trip(exchange::Fault::kDriveRefused);
      return;
    }
    status_.state = exchange::State::kRendering;
    status_.render_epoch = settings_.render_epoch;
    status_.mass = status_.filter == settings_.filter ? settings_.mass : 0;
    status_.target_mass = settings_.mass;
    end_ticks_ = 0;
  }

  void Render(bool wanted) {
    if (wanted && end_ticks_ == 0) {
      status_.mass = status_.filter == settings_.filter ? settings_.mass : 0;
      status_.target_mass = settings_.mass;
    } else if (++end_ticks_ == kEndTicks) {
      status_.state = exchange::State::kReady;
      status_.mass = 0;
      status_.target_mass = 0;
      ++status_.renderings_ended;
    }
  }

  exchange::Crossing& crossing_;
  const exchange::Clock& clock_;
  exchange::Settings settings_;
  exchange::LoopStatus status_;
  uint64_t emergency_stops_seen_ = 0;
  uint64_t epoch_seen_ = 0;
  int end_ticks_ = 0;
  int fault_ticks_ = 0;
  int filter_ticks_ = 0;
  bool drive_refuses_ = false;
  bool ignores_starts_ = false;
};

}  // namespace mwidth::gate
