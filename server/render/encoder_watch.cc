#include "server/render/encoder_watch.h"

#include <algorithm>
#include <cmath>

#include "server/model/estimator.h"

namespace mwidth::render {
namespace {

// Until then the estimators have forgotten a jump: it adds no velocity in the end, so that what remains of it
// falls faster than the filter's own step response.
constexpr double kJumpMemoryS = 1;

}  // namespace

EncoderWatch::EncoderWatch(const LoopConfig& config, double position_quantum) noexcept
    : period_s_(config.period_s),
      quantum_(position_quantum),
      acceleration_limit_(config.watch.acceleration_limit),
      freeze_velocity_(config.watch.freeze_velocity),
      freeze_ticks_(static_cast<uint64_t>(std::llround(config.watch.freeze_s / config.period_s))),
      jump_memory_ticks_(static_cast<uint64_t>(std::llround(kJumpMemoryS / config.period_s))) {}

void EncoderWatch::Follow(int64_t position_counts, uint64_t periods) noexcept {
  // Unsigned, so that counts far apart overflow by the rules.
  const auto moved =
      static_cast<int64_t>(static_cast<uint64_t>(position_counts) - static_cast<uint64_t>(counts_));
  counts_ = position_counts;
  ticks_since_jump_ += periods;
  if (periods > model::AccelerationEstimator::kMaxBridgedPeriods) {
    answers_ = 0;  // As the estimator, which begins anew.
  }
  if (answers_ == 0) {
    answers_ = 1;
    moving_velocity_ = 0;
    still_ticks_ = 0;
    return;
  }
  const double velocity = static_cast<double>(moved) * quantum_ / (static_cast<double>(periods) * period_s_);
  if (moved != 0) {
    moving_velocity_ = velocity;
    still_ticks_ = 0;
  } else {
    still_ticks_ += periods;
  }
  if (answers_ == 2) {
    FollowJump(velocity, periods);
  }
  answers_ = 2;
  velocity_ = velocity;
  periods_ = periods;
}

void EncoderWatch::FollowJump(double velocity, uint64_t periods) noexcept {
  const auto n = static_cast<double>(periods);
  const auto n_before = static_cast<double>(periods_);
  const double rounding = (1 / n + 1 / n_before) * quantum_ / period_s_;
  const double acceleration = (std::abs(velocity - velocity_) - rounding) / ((n + n_before) / 2 * period_s_);
  if (acceleration > acceleration_limit_) {
    jump_acceleration_ = acceleration;
    ticks_since_jump_ = 0;
    moving_velocity_ = 0;  // That was no motion, and what stands still after it does not stop dead.
  }
}

Breach EncoderWatch::Judge() const noexcept {
  if (jump_acceleration_ > 0 && ticks_since_jump_ < jump_memory_ticks_) {
    return {exchange::Fault::kEncoderJump, jump_acceleration_, acceleration_limit_};
  }
  if (still_ticks_ >= freeze_ticks_ && std::abs(moving_velocity_) >= freeze_velocity_) {
    return {exchange::Fault::kEncoderFreeze, std::abs(moving_velocity_), freeze_velocity_};
  }
  return {};
}

}  // namespace mwidth::render
