#include "device/simulated_drive.h"

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace mwidth::device {
namespace {

// Below this a double's counts are whole and far from what int64_t holds.
constexpr double kMaxCounts = 1e15;

SimulatedDriveConfig Validated(const SimulatedDriveConfig& config) {
  if (const auto error = model::Validate(config.loop)) {
    throw std::runtime_error("simulated drive: " + error->Message());
  }
  for (const auto& [name, quantum] : {std::pair{"position_quantum", config.position_quantum},
                                      std::pair{"force_quantum", config.force_quantum}}) {
    if (!std::isfinite(quantum) || quantum <= 0) {
      throw std::runtime_error("simulated drive: " + std::string(name) + " is " + std::to_string(quantum) +
                               "; expected a finite value above 0");
    }
  }
  return config;
}

}  // namespace

SimulatedDrive::SimulatedDrive(const SimulatedDriveConfig& config, std::unique_ptr<HandMotion> hand)
    : config_(Validated(config)), hand_(std::move(hand)), simulation_(config_.loop) {
  if (!hand_) {
    throw std::runtime_error("simulated drive: no hand motion; expected one");
  }
}

DriveInfo SimulatedDrive::Info() const noexcept {
  return {.position_quantum = config_.position_quantum,
          .force_quantum = config_.force_quantum,
          .simulated = true};
}

Enabling SimulatedDrive::Enable() noexcept {
  simulation_.Command(0);
  enabled_ = true;
  return Enabling::kEnabled;
}

void SimulatedDrive::Disable() noexcept {
  simulation_.Command(0);
  enabled_ = false;
}

double SimulatedDrive::HandAt(uint64_t tick) const noexcept {
  return hand_->PositionAt(static_cast<double>(tick - first_tick_) * config_.loop.period_s);
}

void SimulatedDrive::Rest(uint64_t tick) noexcept {
  const double hand = HandAt(tick);
  simulation_.Reset(hand, 0, hand);
  tick_ = tick;
}

Reading SimulatedDrive::Read(uint64_t tick) noexcept {
  if (!started_) {
    started_ = true;
    first_tick_ = tick;
    Rest(tick);
  } else if (tick <= tick_) {
    return {};
  } else if (tick - tick_ > kMaxGapTicks) {
    Rest(tick);
    return {};
  }
  while (tick_ < tick) {
    ++tick_;
    simulation_.Advance(HandAt(tick_));
  }
  const double counts = simulation_.position() / config_.position_quantum;
  if (!(std::abs(counts) < kMaxCounts)) {
    return {};
  }
  return {.ok = true, .position_counts = std::llround(counts)};
}

bool SimulatedDrive::Write(int32_t force_counts) noexcept {
  if (!enabled_ && force_counts != 0) {
    return false;
  }
  simulation_.Command(force_counts * config_.force_quantum);
  return true;
}

}  // namespace mwidth::device
