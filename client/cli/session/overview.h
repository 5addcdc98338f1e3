// A whole session at a glance, however long it is.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "client/cli/session/svg.h"
#include "server/exchange/crossing.h"

namespace mwidth::cli::session {

/// Least and largest values of position, force and mass in equal times, what state the axis was in, and how
/// often which thing was so. Memory does not grow with the session's length.
class Overview {
 public:
  /// Of the ticks `first_tick` to `last_tick`; later ones are counted but not shown.
  Overview(uint64_t first_tick, uint64_t last_tick, double period_s);
  Overview() : Overview(0, 0, 1) {}

  void Add(const exchange::Sample& sample);

  struct StateSpan {
    exchange::State state = exchange::State::kIdle;
    double from_s = 0;
    double to_s = 0;
  };

  /// Seconds from the first tick; interrupted where a whole bucket has no sample.
  std::vector<Point> Position() const { return CurveOf(0); }
  std::vector<Point> Force() const { return CurveOf(1); }
  std::vector<Point> Mass() const { return CurveOf(2); }
  /// At most kMostSpans: later changes of state are not shown.
  const std::vector<StateSpan>& states() const noexcept { return states_; }
  double length_s() const noexcept { return length_s_; }

  uint64_t samples() const noexcept { return samples_; }
  /// By state.
  const std::array<uint64_t, 4>& state_ticks() const noexcept { return state_ticks_; }
  uint64_t stale_ticks() const noexcept { return stale_; }
  uint64_t saturated_ticks() const noexcept { return saturated_; }
  uint64_t slew_limited_ticks() const noexcept { return slew_limited_; }
  double largest_force() const noexcept { return largest_force_; }

 private:
  static constexpr std::size_t kBuckets = 700;
  static constexpr std::size_t kColumns = 3;
  static constexpr std::size_t kMostSpans = 1000;

  struct Range {
    double min = 0;
    double max = 0;
  };
  struct Bucket {
    bool used = false;
    std::array<Range, kColumns> ranges{};
  };
  std::vector<Point> CurveOf(std::size_t column) const;

  uint64_t first_tick_;
  uint64_t ticks_;
  double period_s_;
  double length_s_;
  std::vector<Bucket> buckets_;
  std::vector<StateSpan> states_;
  uint64_t samples_ = 0;
  std::array<uint64_t, 4> state_ticks_{};
  uint64_t stale_ = 0;
  uint64_t saturated_ = 0;
  uint64_t slew_limited_ = 0;
  double largest_force_ = 0;
};

}  // namespace mwidth::cli::session
