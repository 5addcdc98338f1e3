#include "server/record/reduction.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace mwidth::record {
namespace {

// Kaiser's formulas ask for 80 dB; they miss by half of one, so 81 are asked for.
constexpr double kAttenuationDb = 81;
// Of the new Nyquist frequency.
constexpr double kFlatTo = 0.8;

double Kaiser(double beta, double x) {
  return std::cyl_bessel_i(0, beta * std::sqrt(std::max(0.0, 1 - x * x))) / std::cyl_bessel_i(0, beta);
}

}  // namespace

std::vector<double> LowPassTaps(uint32_t decimation) {
  if (decimation == 1) {
    return {1};
  }
  // In radians a tick.
  const double nyquist = std::numbers::pi / decimation;
  const double transition = (1 - kFlatTo) * nyquist;
  const double cutoff = nyquist - 0.5 * transition;
  const double beta = 0.1102 * (kAttenuationDb - 8.7);
  const auto reach = static_cast<std::size_t>(std::ceil((kAttenuationDb - 7.95) / (2.285 * transition) / 2));
  std::vector<double> taps(reach + 1);
  taps[0] = cutoff / std::numbers::pi;
  double sum = taps[0];
  for (std::size_t i = 1; i <= reach; ++i) {
    const auto x = static_cast<double>(i);
    taps[i] =
        std::sin(cutoff * x) / (std::numbers::pi * x) * Kaiser(beta, x / static_cast<double>(reach + 1));
    sum += 2 * taps[i];
  }
  for (double& tap : taps) {
    tap /= sum;
  }
  return taps;
}

DecimatingFilter::DecimatingFilter(uint32_t decimation)
    : decimation_(decimation), taps_(LowPassTaps(decimation)), reach_(taps_.size() - 1) {}

std::optional<exchange::Sample> DecimatingFilter::Push(const exchange::Sample& sample) {
  // A sample is begun at the first tick under its filter or not at all: so none is made of half of them.
  if ((sample.tick + reach_) % decimation_ == 0) {
    pending_.emplace_back().tick = sample.tick + reach_;
  }
  for (Pending& pending : pending_) {
    const double tap =
        taps_[pending.tick > sample.tick ? pending.tick - sample.tick : sample.tick - pending.tick];
    pending.position += tap * sample.position;
    pending.velocity += tap * sample.velocity;
    pending.acceleration += tap * sample.acceleration;
    pending.force += tap * sample.force;
    pending.mass += tap * sample.mass;
    if (pending.tick == sample.tick) {
      pending.sample = sample;
    }
  }
  if (pending_.empty() || pending_.front().tick + reach_ != sample.tick) {
    return std::nullopt;
  }
  const Pending& done = pending_.front();
  exchange::Sample filtered = done.sample;
  filtered.position = done.position;
  filtered.velocity = done.velocity;
  filtered.acceleration = done.acceleration;
  filtered.force = done.force;
  filtered.mass = done.mass;
  pending_.pop_front();
  return filtered;
}

Reducer::Reducer(Reduction reduction, uint32_t decimation) : reduction_(reduction), decimation_(decimation) {
  if (reduction == Reduction::kLowPass) {
    filter_.emplace(decimation);
  }
}

std::optional<ReducedSample> Reducer::Push(const exchange::Sample& sample) {
  if (filter_) {
    const std::optional<exchange::Sample> filtered = filter_->Push(sample);
    return filtered ? std::optional(ReducedSample{.sample = *filtered, .extremes = {}}) : std::nullopt;
  }
  if (reduction_ == Reduction::kMinMax) {
    Widen(sample);
  }
  if (sample.tick % decimation_ != 0) {
    return std::nullopt;
  }
  ReducedSample reduced{.sample = sample, .extremes = extremes_.value_or(Extremes{})};
  extremes_.reset();
  return reduced;
}

void Reducer::Reset() {
  extremes_.reset();
  if (filter_) {
    filter_->Reset();
  }
}

void Reducer::Widen(const exchange::Sample& sample) {
  if (!extremes_) {
    extremes_ = {.position_min = sample.position,
                 .position_max = sample.position,
                 .velocity_min = sample.velocity,
                 .velocity_max = sample.velocity,
                 .acceleration_min = sample.acceleration,
                 .acceleration_max = sample.acceleration,
                 .force_min = sample.force,
                 .force_max = sample.force};
    return;
  }
  const auto widen = [](double value, double& min, double& max) {
    min = std::min(min, value);
    max = std::max(max, value);
  };
  widen(sample.position, extremes_->position_min, extremes_->position_max);
  widen(sample.velocity, extremes_->velocity_min, extremes_->velocity_max);
  widen(sample.acceleration, extremes_->acceleration_min, extremes_->acceleration_max);
  widen(sample.force, extremes_->force_min, extremes_->force_max);
}

}  // namespace mwidth::record
