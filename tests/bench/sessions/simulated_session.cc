#include "tests/bench/sessions/simulated_session.h"

#include <array>
#include <numbers>
#include <stdexcept>

namespace mwidth::bench {
namespace {

constexpr int64_t kPeriodNs = 1'000'000;
constexpr uint64_t kTicksOfAMass = 30'000;

std::unique_ptr<device::HandMotion> Hand(const std::optional<std::filesystem::path>& recording) {
  if (recording) {
    return std::make_unique<device::RecordedMotion>(*recording, model::AxisKind::kRotary);
  }
  return std::make_unique<device::MinimumJerkReach>(
      device::ReachParameters{.amplitude = std::numbers::pi / 6, .duration_s = 0.8, .hold_s = 1.2});
}

device::SimulatedDriveConfig Drive() {
  return {.loop = {.device_mass = 0.2084,
                   .device_damping = 0.1215,
                   .hand_mass = 0.0685,
                   .hand_damping = 1,
                   .hand_stiffness = 25,
                   .period_s = 1e-3,
                   .cutoff_hz = 20},
          .position_quantum = 7.1585e-5,
          .force_quantum = 1e-3};
}

render::LoopConfig Loop() {
  render::LoopConfig config;
  config.period_s = 1e-3;
  config.cutoff_hz = 20;
  config.force_limit = 10;
  config.position_min = -3;
  config.position_max = 4;
  config.velocity_limit = 10;
  config.max_missed_ticks = 16;
  config.watch.window_s = 5;
  config.watch.saturation_s = 4.75;
  config.watch.acceleration_limit = 1000;
  config.watch.freeze_velocity = 0.3;
  config.hand_monitor.enabled = false;
  return config;
}

}  // namespace

SimulatedSession::SimulatedSession(Wakeups wakeups, const std::optional<std::filesystem::path>& recording)
    : wakeups_(wakeups),
      drive_(Drive(), Hand(recording)),
      config_(Loop()),
      tick_(config_, drive_, *crossing_) {
  settings_.rendering = true;
  settings_.render_epoch = 1;
  settings_.lease_deadline_ns = INT64_MAX;
}

exchange::Sample SimulatedSession::Next() {
  constexpr std::array kMasses{0.2, -0.03, 0.4, 0.0};
  if (number_ % kTicksOfAMass == 0) {
    settings_.mass = kMasses[number_ / kTicksOfAMass % kMasses.size()];
    ++settings_.sequence;
    crossing_->settings.Post(settings_);
  }
  int64_t late_ns = 0;
  if (wakeups_ == Wakeups::kLate) {
    late_ns = 4000 + static_cast<int64_t>(std::exponential_distribution<double>(1.0 / 6000)(random_));
    late_ns += random_() % 1000 == 0 ? 100'000 : 0;
  }
  ++number_;
  tick_.Run(number_, 1'000'000'000'000 + static_cast<int64_t>(number_) * kPeriodNs + late_ns, 0);
  exchange::Sample sample;
  if (!crossing_->samples.Pop(sample) || sample.state != exchange::State::kRendering) {
    throw std::runtime_error("the simulated axis does not render at tick " + std::to_string(number_));
  }
  return sample;
}

record::SessionAxis SimulatedSession::axis() const {
  const device::DriveInfo info = drive_.Info();
  return {.name = "elbow",
          .rotary = true,
          .period_s = config_.period_s,
          .position_quantum = info.position_quantum,
          .force_quantum = info.force_quantum,
          .acceleration_quantum = info.acceleration_quantum,
          .force_limit = config_.force_limit,
          .force_slew_limit = config_.force_slew_limit};
}

}  // namespace mwidth::bench
