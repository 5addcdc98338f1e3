// A drive that costs next to nothing: a reach that was worked out before, played again and again.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "device/drive.h"

namespace mwidth::bench {

/// 30 degrees of a joint and back, smoothly, in 1024 ticks, whatever force is commanded. Rt but for the
/// constructor.
class ReplayDrive final : public device::Drive {
 public:
  ReplayDrive() {
    constexpr double kAmplitude = 0.5235987755982988;
    constexpr double kTurn = 6.283185307179586;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      const double phase = kTurn * static_cast<double>(i) / static_cast<double>(counts_.size());
      counts_[i] = std::llround(kAmplitude * (1 - std::cos(phase)) / 2 / kQuantum);
    }
  }

  device::DriveInfo Info() const noexcept override {
    return {.position_quantum = kQuantum, .force_quantum = 1e-3, .simulated = true};
  }
  device::Enabling Enable() noexcept override { return device::Enabling::kEnabled; }
  void Disable() noexcept override {}
  device::Reading Read(uint64_t tick) noexcept override {
    return {.ok = true, .position_counts = counts_[tick % counts_.size()]};
  }
  bool Write(int32_t /*force_counts*/) noexcept override { return true; }

 private:
  static constexpr double kQuantum = 1e-5;
  std::array<int64_t, 1024> counts_{};
};

}  // namespace mwidth::bench
