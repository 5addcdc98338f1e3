#include "device/simulated_drive.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace mwidth::device {
namespace {

// Below this a double's counts are whole and far from what int64_t holds.
constexpr double kMaxCounts = 1e15;
constexpr double kMaxAccelerationCounts = std::numeric_limits<int32_t>::max();

SimulatedDriveConfig Validated(const SimulatedDriveConfig& config) {
  model::LoopParameters loop = config.loop;
  if (config.acceleration_quantum != 0) {
    loop.estimator = model::EstimatorKind::kAccelerometer;  // whose bandwidth is then looked at, too
  }
  if (const auto error = model::Validate(loop)) {
    throw std::runtime_error("simulated drive: " + error->Message());
  }
  for (const auto& [name, quantum] : {std::pair{"position_quantum", config.position_quantum},
                                      std::pair{"force_quantum", config.force_quantum}}) {
    if (!std::isfinite(quantum) || quantum <= 0) {
      throw std::runtime_error("simulated drive: " + std::string(name) + " is " + std::to_string(quantum) +
                               "; expected a finite value above 0");
    }
  }
  if (!std::isfinite(config.acceleration_quantum) || config.acceleration_quantum < 0) {
    throw std::runtime_error("simulated drive: acceleration_quantum is " +
                             std::to_string(config.acceleration_quantum) +
                             "; expected a finite value, at least 0");
  }
  return config;
}

std::variant<model::HybridSimulation, model::AccelerometerSimulation> SimulationOf(
    const SimulatedDriveConfig& config) {
  if (config.acceleration_quantum > 0) {
    return model::AccelerometerSimulation(config.loop);
  }
  return model::HybridSimulation(config.loop);
}

// std::visit, which may throw, without its throw.
template <typename Simulation, typename Function>
auto On(Simulation& simulation, const Function& function) noexcept {
  if (auto* smooth = std::get_if<model::HybridSimulation>(&simulation)) {
    return function(*smooth);
  }
  return function(*std::get_if<model::AccelerometerSimulation>(&simulation));
}

}  // namespace

SimulatedDrive::SimulatedDrive(const SimulatedDriveConfig& config, std::unique_ptr<HandMotion> hand)
    : config_(Validated(config)), hand_(std::move(hand)), simulation_(SimulationOf(config_)) {
  if (!hand_) {
    throw std::runtime_error("simulated drive: no hand motion; expected one");
  }
}

DriveInfo SimulatedDrive::Info() const noexcept {
  return {.position_quantum = config_.position_quantum,
          .force_quantum = config_.force_quantum,
          .simulated = true,
          .acceleration_quantum = config_.acceleration_quantum,
          .accelerometer_bandwidth_hz =
              config_.acceleration_quantum > 0 ? config_.loop.accelerometer_bandwidth_hz : 0};
}

void SimulatedDrive::Command(double force) noexcept {
  On(simulation_, [force](auto& simulation) { simulation.Command(force); });
}

Enabling SimulatedDrive::Enable() noexcept {
  Command(0);
  enabled_ = true;
  return Enabling::kEnabled;
}

void SimulatedDrive::Disable() noexcept {
  Command(0);
  enabled_ = false;
}

double SimulatedDrive::HandAt(uint64_t tick) const noexcept {
  return hand_->PositionAt(static_cast<double>(tick - first_tick_) * config_.loop.period_s);
}

void SimulatedDrive::Rest(uint64_t tick) noexcept {
  const double hand = HandAt(tick);
  On(simulation_, [hand](auto& simulation) { simulation.Reset(hand, 0, hand); });
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
    On(simulation_, [hand = HandAt(tick_)](auto& simulation) { simulation.Advance(hand); });
  }
  const double counts =
      On(simulation_, [](auto& simulation) { return simulation.position(); }) / config_.position_quantum;
  const auto* sensed = std::get_if<model::AccelerometerSimulation>(&simulation_);
  const double acceleration_counts =
      sensed != nullptr ? std::round(sensed->sensed() / config_.acceleration_quantum) : 0;
  if (!(std::abs(counts) < kMaxCounts && std::abs(acceleration_counts) <= kMaxAccelerationCounts)) {
    return {};
  }
  return {.ok = true,
          .position_counts = std::llround(counts),
          .acceleration_counts = static_cast<int32_t>(acceleration_counts)};
}

bool SimulatedDrive::Write(int32_t force_counts) noexcept {
  if (!enabled_ && force_counts != 0) {
    return false;
  }
  Command(force_counts * config_.force_quantum);
  return true;
}

}  // namespace mwidth::device
