// What must hold in every tick of every history, tried on many random ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <random>

#include "tests/server/render/axis.h"

namespace mwidth::render {
namespace {

using exchange::Fault;
using exchange::LoopStatus;
using exchange::State;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr int kHistories = 10'000;  // A sanitizer makes them ten times as slow.
#else
constexpr int kHistories = 100'000;
#endif
constexpr int kTicks = 90;

// Slow, so that a whole ramp of 0.2 s is 20 ticks, and that of a fault 5.
LoopConfig SlowConfig() {
  LoopConfig config = TestConfig();
  config.period_s = 0.01;
  return config;
}

constexpr uint64_t kFaultRampTicks = 5;

// One axis under random commands and failures, and what an onlooker expects of it from the contract alone.
class History {
 public:
  explicit History(uint64_t seed) : axis_(SlowConfig()), random_(seed) {}

  // A crossing with a past, and a loop made anew on it: nothing of the past may begin by itself.
  void Renew() {
    tick_.emplace(axis_.config, axis_.drive, *axis_.crossing);
    axis_.drive.Disable();
    axis_.drive.accepts_enable = axis_.drive.answers_reads = axis_.drive.takes_writes = true;
    axis_.status = {};
    tick_number_ = 0;
    forfeited_epoch_ = axis_.settings.render_epoch;
    emergency_stops_obeyed_ = 0;
    silence_ = 0;
    expired_ns_ = 0;
  }

  void Step() {
    Disturb();
    const uint64_t missed = Chance(0.02) ? random_() % 8 : 0;
    before_ = axis_.status;
    const bool was_enabled = axis_.drive.enabled;
    tick_number_ += 1 + missed;
    axis_.now_ns += static_cast<int64_t>(1 + missed) * axis_.period_ns;
    tick_->Run(tick_number_, axis_.now_ns, missed);
    ASSERT_TRUE(axis_.crossing->status.Take(axis_.status));
    ASSERT_TRUE(axis_.crossing->samples.Pop(axis_.sample));
    CheckForce();
    CheckStart();
    CheckMass();
    CheckFault();
    CheckEmergencyStop();
    CheckLease();
    CheckSilence(was_enabled, missed);
    ++seen_states[static_cast<std::size_t>(axis_.status.state)];
    ++seen_faults[static_cast<std::size_t>(axis_.status.fault.fault)];
  }

  std::array<uint64_t, 4> seen_states{};
  std::array<uint64_t, 8> seen_faults{};
  uint64_t full_rampings = 0;

 private:
  bool Chance(double probability) {
    return std::uniform_real_distribution<double>(0, 1)(random_) < probability;
  }
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  void Disturb() {
    auto& settings = axis_.settings;
    if (Chance(0.06)) {
      axis_.Start(Uniform(-0.5, 3), Chance(0.3) ? 0 : Uniform(0, 0.3));
      settings.lease_deadline_ns = axis_.now_ns + (Chance(0.9) ? 600'000'000 : -1);
      axis_.Post();  // The newest of several posts between two ticks wins.
    }
    if (Chance(0.05)) {
      settings.mass = Chance(0.05) ? std::numeric_limits<double>::quiet_NaN() : Uniform(-0.5, 3);
      settings.ramp_s = Chance(0.1) ? std::numeric_limits<double>::quiet_NaN() : Uniform(0, 0.3);
      axis_.Post();
    }
    if (Chance(0.05)) {
      settings.lease_deadline_ns = axis_.now_ns + (Chance(0.8) ? 600'000'000 : -1);
      axis_.Post();
    }
    if (Chance(0.02)) {
      settings.rendering = Chance(0.3);
      axis_.Post();
    }
    if (Chance(0.005)) {
      axis_.EmergencyStop();
    }
    if (Chance(0.1) && axis_.status.state == State::kFault) {
      axis_.ClearFault();
    }
    DisturbDrive();
  }

  void DisturbDrive() {
    auto& drive = axis_.drive;
    drive.answers_reads = drive.answers_reads ? !Chance(0.02) : Chance(0.4);
    drive.takes_writes = drive.takes_writes ? !Chance(0.01) : Chance(0.4);
    drive.accepts_enable = !Chance(0.1);
    angle_ += 0.1;
    const double jump = Chance(0.003) ? 1.2 : 0;  // Beyond the limits of position or velocity.
    axis_.SetPosition(0.1 * std::sin(angle_) + jump);
  }

  // A force only while rendering, or within the ramp of a fault; within its limit; and no drive enabled
  // otherwise.
  void CheckForce() {
    const State state = axis_.status.state;
    if (state == State::kFault && before_.state != State::kFault) {
      latched_tick_ = tick_number_;
    }
    const bool in_fault_ramp = state == State::kFault && tick_number_ < latched_tick_ + kFaultRampTicks;
    if (state != State::kRendering && !in_fault_ramp) {
      if (state != State::kReady || axis_.drive.takes_writes) {  // A zero not taken is silence: see there.
        ASSERT_EQ(axis_.drive.acting_counts, 0);
      }
      ASSERT_EQ(axis_.sample.force_counts, 0);
      ASSERT_EQ(axis_.sample.mass, 0);
      ASSERT_EQ(axis_.drive.enabled, state == State::kReady);
    }
    ASSERT_LE(std::abs(axis_.sample.force), axis_.config.force_limit);
    ASSERT_EQ(axis_.sample.state, state);
    ASSERT_EQ(axis_.drive.writes_while_disabled, 0);
    if (axis_.drive.takes_writes && axis_.drive.enabled) {
      ASSERT_EQ(axis_.sample.force_counts, axis_.drive.acting_counts);
    }
  }

  // Rendering begins only by a start that is new, wanted now, and was not made in a fault or before this
  // loop.
  void CheckStart() {
    const auto& settings = axis_.settings;
    const bool began = axis_.status.render_epoch != before_.render_epoch;
    if (axis_.status.state == State::kRendering && before_.state != State::kRendering) {
      ASSERT_TRUE(before_.state == State::kIdle || before_.state == State::kReady);
      ASSERT_TRUE(began);
    }
    if (began) {
      ASSERT_GT(settings.render_epoch, forfeited_epoch_);
      ASSERT_EQ(axis_.status.render_epoch, settings.render_epoch);
      ASSERT_TRUE(settings.rendering);
      ASSERT_GT(settings.lease_deadline_ns, axis_.now_ns);
    }
    const bool ending = before_.state == State::kRendering && axis_.status.target_mass == 0;
    if (!ending || axis_.status.state == State::kFault) {
      forfeited_epoch_ = settings.render_epoch;
    }
    const bool ended = axis_.status.renderings_ended != before_.renderings_ended;
    const bool rendered = before_.state == State::kRendering || began;
    ASSERT_EQ(ended, rendered && axis_.status.state != State::kRendering);
  }

  // The mass lies between zero and the masses that were set since rendering began, and moves towards its
  // target.
  void CheckMass() {
    if (before_.state != State::kRendering && before_.state != State::kFault) {
      lowest_mass_ = highest_mass_ = 0;
    }
    if (std::isfinite(axis_.settings.mass) && axis_.status.target_mass == axis_.settings.mass) {
      lowest_mass_ = std::min(lowest_mass_, axis_.settings.mass);
      highest_mass_ = std::max(highest_mass_, axis_.settings.mass);
    }
    ASSERT_TRUE(std::isfinite(axis_.sample.mass));
    ASSERT_GE(axis_.sample.mass, lowest_mass_);
    ASSERT_LE(axis_.sample.mass, highest_mass_);
    if (axis_.sample.mass != 0 && axis_.sample.mass == axis_.settings.mass) {
      ++full_rampings;
    }
  }

  // A fault stays until it is cleared, and only an emergency stop takes its place.
  void CheckFault() {
    if (before_.state != State::kFault) {
      return;
    }
    if (axis_.status.state == State::kFault) {
      ASSERT_GE(axis_.status.fault.number, before_.fault.number);
      if (axis_.status.fault.number != before_.fault.number) {
        ASSERT_EQ(axis_.status.fault.fault, Fault::kEmergencyStop);
      }
    } else {
      ASSERT_EQ(axis_.status.state, State::kIdle);
      ASSERT_GE(axis_.settings.cleared_fault_number, before_.fault.number);
    }
  }

  void CheckEmergencyStop() {
    if (axis_.settings.emergency_stops > emergency_stops_obeyed_) {
      emergency_stops_obeyed_ = axis_.settings.emergency_stops;
      ASSERT_EQ(axis_.status.fault.fault, Fault::kEmergencyStop);
      ASSERT_EQ(axis_.status.state, State::kFault);
      ASSERT_EQ(axis_.drive.acting_counts, 0);
      ASSERT_FALSE(axis_.drive.enabled);
    }
  }

  // 500 ms after the deadline there is no force, unless a new start with a new lease came since.
  void CheckLease() {
    if (axis_.settings.lease_deadline_ns > axis_.now_ns) {
      expired_ns_ = 0;
    } else if (expired_ns_ == 0) {
      expired_ns_ = axis_.now_ns;
    } else if (axis_.now_ns > expired_ns_ + 500'000'000) {
      ASSERT_NE(axis_.status.state, State::kRendering);
      ASSERT_EQ(axis_.drive.acting_counts, 0);
    }
  }

  // An enabled drive without an answer for three ticks has no force and is in fault.
  void CheckSilence(bool was_enabled, uint64_t missed) {
    const bool answered = axis_.drive.answers_reads && (axis_.drive.takes_writes || !was_enabled);
    silence_ = answered ? 0 : silence_ + 1 + (silence_ > 0 ? missed : 0);
    if (was_enabled && silence_ > 2) {
      ASSERT_EQ(axis_.drive.acting_counts, 0);
      ASSERT_EQ(axis_.status.state, State::kFault);
    }
  }

  Axis axis_;
  std::optional<Tick> tick_;
  std::mt19937_64 random_;
  LoopStatus before_;
  uint64_t tick_number_ = 0;
  uint64_t forfeited_epoch_ = 0;
  uint64_t emergency_stops_obeyed_ = 0;
  uint64_t latched_tick_ = 0;
  uint64_t silence_ = 0;
  int64_t expired_ns_ = 0;
  double lowest_mass_ = 0;
  double highest_mass_ = 0;
  double angle_ = 0;
};

TEST(SupervisorPropertyTest, HoldsItsPromisesInEveryTickOfManyRandomHistories) {
  History history(20120709);
  for (int h = 0; h < kHistories; ++h) {
    history.Renew();
    for (int k = 0; k < kTicks; ++k) {
      history.Step();
      if (HasFatalFailure()) {
        FAIL() << "history " << h << ", step " << k;
      }
    }
  }
  // Nothing was proved about what never happened.
  for (const uint64_t count : history.seen_states) {
    EXPECT_GT(count, kHistories / 10);
  }
  for (const uint64_t count : history.seen_faults) {
    EXPECT_GT(count, kHistories / 100);
  }
  EXPECT_GT(history.full_rampings, kHistories);
}

}  // namespace
}  // namespace mwidth::render
