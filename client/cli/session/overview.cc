#include "client/cli/session/overview.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mwidth::cli::session {

Overview::Overview(uint64_t first_tick, uint64_t last_tick, double period_s)
    : first_tick_(first_tick),
      ticks_(last_tick >= first_tick ? last_tick - first_tick + 1 : 1),
      period_s_(period_s),
      length_s_(static_cast<double>(ticks_) * period_s),
      buckets_(std::min<uint64_t>(kBuckets, ticks_)) {}

void Overview::Add(const exchange::Sample& sample) {
  ++samples_;
  stale_ += sample.position_stale ? 1 : 0;
  saturated_ += sample.saturated ? 1 : 0;
  slew_limited_ += sample.slew_limited ? 1 : 0;
  largest_force_ = std::max(largest_force_, std::abs(sample.force));
  ++state_ticks_.at(static_cast<std::size_t>(sample.state) % state_ticks_.size());
  const uint64_t tick = sample.tick - first_tick_;
  if (sample.tick < first_tick_ || tick >= ticks_) {
    return;
  }
  const double time_s = static_cast<double>(tick) * period_s_;
  if (states_.empty() || states_.back().state != sample.state) {
    if (states_.size() < kMostSpans) {
      states_.push_back({.state = sample.state, .from_s = time_s, .to_s = time_s});
    }
  }
  if (states_.back().state == sample.state) {
    states_.back().to_s = time_s + period_s_;
  }
  Bucket& bucket = buckets_[static_cast<std::size_t>(static_cast<double>(tick) / static_cast<double>(ticks_) *
                                                     static_cast<double>(buckets_.size()))];
  const std::array values{sample.position, sample.force, sample.mass};
  for (std::size_t column = 0; column < kColumns; ++column) {
    Range& range = bucket.ranges[column];
    range.min = bucket.used ? std::min(range.min, values[column]) : values[column];
    range.max = bucket.used ? std::max(range.max, values[column]) : values[column];
  }
  bucket.used = true;
}

std::vector<Point> Overview::CurveOf(std::size_t column) const {
  std::vector<Point> curve;
  const double width_s = length_s_ / static_cast<double>(buckets_.size());
  for (std::size_t i = 0; i < buckets_.size(); ++i) {
    const double middle_s = (static_cast<double>(i) + 0.5) * width_s;
    if (!buckets_[i].used) {
      curve.push_back({middle_s, std::numeric_limits<double>::quiet_NaN()});
      continue;
    }
    const Range& range = buckets_[i].ranges[column];
    curve.push_back({middle_s, range.min});
    if (range.max != range.min) {
      curve.push_back({middle_s, range.max});
    }
  }
  return curve;
}

}  // namespace mwidth::cli::session
