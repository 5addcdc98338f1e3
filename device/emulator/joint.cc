#include "device/emulator/joint.h"

#include <algorithm>
#include <utility>

namespace mwidth::device::emulator {
namespace {

constexpr int64_t kStepNs = 100'000;

SimulatedDriveConfig Simulation(const JointConfig& config) {
  SimulatedDriveConfig simulation{.loop = config.plant,
                                  .position_quantum = config.position_quantum,
                                  .force_quantum = config.force_quantum};
  simulation.loop.period_s = Joint::kStepS;
  simulation.loop.delay_s = 0;
  return simulation;
}

}  // namespace

Joint::Joint(const JointConfig& config, std::unique_ptr<HandMotion> hand)
    : config_(config), simulation_(Simulation(config), std::move(hand)) {}

void Joint::AdvanceTo(int64_t now_ns) {
  if (start_ns_ == 0) {
    start_ns_ = now_ns;
    fed_ns_ = now_ns;
  }
  const auto step = static_cast<uint64_t>(std::max<int64_t>(0, now_ns - start_ns_) / kStepNs) + 1;
  // In parts that the simulation takes at once.
  while (step_ < step) {
    step_ = std::min(step, step_ + SimulatedDrive::kMaxGapTicks);
    if (const Reading reading = simulation_.Read(step_); reading.ok) {
      position_counts_ = reading.position_counts;
    }
  }
}

int64_t Joint::PositionCounts(int64_t now_ns) {
  const std::lock_guard lock(mutex_);
  AdvanceTo(now_ns);
  if (encoder_fault_ != EncoderFault::kFrozen) {
    shown_counts_ = position_counts_ + jump_counts_;
  }
  return shown_counts_;
}

void Joint::SetForce(int64_t now_ns, int32_t counts) {
  const std::lock_guard lock(mutex_);
  AdvanceTo(now_ns);
  force_counts_ = enabled_ ? counts : 0;
  // The simulation takes the paper's force, which acts against the positive direction.
  simulation_.Write(-force_counts_);
}

void Joint::Switch(bool enabled) {
  if (enabled == enabled_) {
    return;
  }
  enabled_ = enabled;
  force_counts_ = 0;
  if (enabled) {
    simulation_.Enable();
  } else {
    simulation_.Disable();
  }
}

void Joint::SetEnabled(int64_t now_ns, bool enabled) {
  const std::lock_guard lock(mutex_);
  AdvanceTo(now_ns);
  Switch(enabled);
}

bool Joint::enabled() const {
  const std::lock_guard lock(mutex_);
  return enabled_;
}

int32_t Joint::force_counts() const {
  const std::lock_guard lock(mutex_);
  return force_counts_;
}

void Joint::Feed(int64_t now_ns) {
  const std::lock_guard lock(mutex_);
  fed_ns_ = now_ns;
}

void Joint::Turn(int64_t now_ns) {
  const std::lock_guard lock(mutex_);
  if (start_ns_ == 0) {
    AdvanceTo(now_ns);
  }
  const auto patience_ns = static_cast<int64_t>(config_.watchdog_s * 1e9);
  if (patience_ns > 0 && enabled_ && now_ns - fed_ns_ > patience_ns) {
    TripAt(fed_ns_ + patience_ns, config_.watchdog_s);
  }
  AdvanceTo(now_ns);
}

void Joint::TripAt(int64_t now_ns, double after_s) {
  AdvanceTo(now_ns);
  Switch(false);
  trips_ = {trips_.count + 1, after_s};
}

void Joint::Trip(int64_t now_ns, double after_s) {
  const std::lock_guard lock(mutex_);
  TripAt(now_ns, after_s);
}

Trips Joint::trips() const {
  const std::lock_guard lock(mutex_);
  return trips_;
}

void Joint::SetEncoderFault(EncoderFault fault) {
  const std::lock_guard lock(mutex_);
  encoder_fault_ = fault;
}

void Joint::JumpEncoder(int64_t counts) {
  const std::lock_guard lock(mutex_);
  jump_counts_ += counts;
}

}  // namespace mwidth::device::emulator
