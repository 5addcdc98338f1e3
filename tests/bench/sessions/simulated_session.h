// Samples of a person who reaches with an elbow exoskeleton while a virtual mass is rendered.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <random>

#include "device/simulated_drive.h"
#include "server/exchange/crossing.h"
#include "server/record/session/session_info.h"
#include "server/render/tick.h"

namespace mwidth::bench {

/// When ticks run: exactly on time, as a lock-step simulation has it, or as late as on a computer: 4 us and
/// an exponential of 6 us mean, with one in a thousand 100 us later.
enum class Wakeups : uint8_t { kExact, kLate };

/// The shipped elbow (deploy/config/elbow.toml) at 1 kHz with the loop's own tick, in simulated time. The
/// hand plays `recording` where there is one, the built-in minimum-jerk reaches elsewhere. The mass changes
/// every 30 s between 0.2, -0.03, 0.4 and 0 kg m^2.
class SimulatedSession {
 public:
  SimulatedSession(Wakeups wakeups, const std::optional<std::filesystem::path>& recording);

  exchange::Sample Next();
  record::SessionAxis axis() const;

 private:
  Wakeups wakeups_;
  std::mt19937_64 random_{20120709};
  device::SimulatedDrive drive_;
  render::LoopConfig config_;
  std::unique_ptr<exchange::Crossing> crossing_ = std::make_unique<exchange::Crossing>();
  render::Tick tick_;
  exchange::Settings settings_;
  uint64_t number_ = 0;
};

}  // namespace mwidth::bench
