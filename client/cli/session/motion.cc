#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "client/cli/session/movement.h"
#include "client/cli/session/smoothing.h"
#include "server/model/estimator.h"

namespace mwidth::cli::session {
namespace {

using Column = std::vector<double>;

// `x` at every tick from the first to the last: straight lines between samples.
Column EveryTick(const std::vector<uint64_t>& tick, const Column& x) {
  Column every;
  every.reserve(tick.back() - tick.front() + 1);
  every.push_back(x.front());
  for (std::size_t k = 1; k < tick.size(); ++k) {
    const uint64_t step = tick[k] - tick[k - 1];
    for (uint64_t i = 1; i < step; ++i) {
      const double share = static_cast<double>(i) / static_cast<double>(step);
      every.push_back(x[k - 1] + (x[k] - x[k - 1]) * share);
    }
    every.push_back(x[k]);
  }
  return every;
}

// Empty where no such estimator runs.
Column ExpectedForce(const Motion& motion, const Column& smooth_position,
                     const std::vector<std::pair<std::size_t, exchange::Filter>>& filters) {
  const auto kind = static_cast<model::EstimatorKind>(filters.front().second.estimator);
  const double cutoff_hz = filters.front().second.cutoff_hz;
  if (filters.size() != 1 || !model::Runs(kind, motion.period_s, cutoff_hz) || model::IsAccelerometer(kind)) {
    return {};
  }
  model::AccelerationEstimator estimator(motion.period_s, cutoff_hz, kind);
  Column force(smooth_position.size());
  for (std::size_t k = 0; k < force.size(); ++k) {
    force[k] = motion.mass[k] * estimator.Update(smooth_position[k]);
  }
  return force;
}

std::optional<double> NumberIn(const std::map<std::string, std::string>& metadata, const std::string& key) {
  const auto entry = metadata.find(key);
  if (entry == metadata.end()) {
    return std::nullopt;
  }
  const std::string& text = entry->second;
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

std::optional<double> PositionIn(const std::map<std::string, std::string>& metadata, const std::string& key,
                                 bool rotary) {
  if (const auto plain = NumberIn(metadata, key + (rotary ? "_rad" : "_m"))) {
    return plain;
  }
  if (const auto degrees = NumberIn(metadata, key + "_deg"); degrees && rotary) {
    return *degrees * std::numbers::pi / 180;
  }
  return NumberIn(metadata, key);
}

}  // namespace

std::optional<Motion> MotionOf(const Trial& trial, const record::SessionAxis& axis, std::string& why) {
  const Smoothing smoothing(axis.period_s);
  if (trial.tick.empty()) {
    why = "no position was recorded in it";
    return std::nullopt;
  }
  for (std::size_t k = 1; k < trial.tick.size(); ++k) {
    if (static_cast<double>(trial.tick[k] - trial.tick[k - 1] - 1) * axis.period_s > kMaxGapS) {
      why = "too many ticks in a row have no position";
      return std::nullopt;
    }
  }
  if (trial.tick.back() - trial.tick.front() + 1 < smoothing.window()) {
    why = "it is too short to tell velocity and acceleration";
    return std::nullopt;
  }
  Motion motion{.first_tick = trial.tick.front(),
                .period_s = axis.period_s,
                .position_quantum = axis.position_quantum,
                .position = EveryTick(trial.tick, trial.position),
                .mass = EveryTick(trial.tick, trial.mass)};
  motion.velocity = smoothing.Apply(motion.position, 1);
  motion.acceleration = smoothing.Apply(motion.position, 2);
  motion.force = smoothing.Apply(EveryTick(trial.tick, trial.force), 0);
  const Column expected = ExpectedForce(motion, smoothing.Apply(motion.position, 0), trial.filters);
  if (!expected.empty()) {
    motion.expected_force = smoothing.Apply(expected, 0);
  }
  return motion;
}

Task TaskOf(const Trial& trial, bool rotary) {
  return {.start = PositionIn(trial.metadata, "start", rotary),
          .target = PositionIn(trial.metadata, "target", rotary)};
}

}  // namespace mwidth::cli::session
