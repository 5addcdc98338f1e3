// What must hold in every tick of every history, tried on many random ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <deque>
#include <optional>

#include "tests/server/render/random_axis.h"

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

constexpr uint64_t kFaultRampTicks = 5;

// What was so in the last 40 ticks, and whether that is too much.
class ExactWindow {
 public:
  explicit ExactWindow(std::size_t allowed_ticks) : allowed_ticks_(allowed_ticks) {}
  void Clear() {
    ticks_.clear();
    spent_ = 0;
  }
  void Pass(uint64_t ticks, bool spent) {
    for (; ticks > 0; --ticks) {
      ticks_.push_back(spent);
      spent_ += spent ? 1 : 0;
      if (ticks_.size() > 40) {
        spent_ -= ticks_.front() ? 1 : 0;
        ticks_.pop_front();
      }
    }
  }
  bool Exceeded() const { return spent_ > allowed_ticks_; }

 private:
  std::size_t allowed_ticks_;
  std::deque<bool> ticks_;
  std::size_t spent_ = 0;
};

// What an onlooker expects of the axis, from the contract alone.
class History {
 public:
  explicit History(uint64_t seed) : random_axis_(seed) {}

  // A crossing with a past, and a loop made anew on it: nothing of the past may begin by itself.
  void Renew() {
    tick_.emplace(axis_.config, axis_.drive, *axis_.crossing);
    axis_.drive.Disable();
    random_axis_.Repair();
    axis_.status = {};
    tick_number_ = 0;
    forfeited_epoch_ = axis_.settings.render_epoch;
    emergency_stops_obeyed_ = 0;
    silence_ = 0;
    arming_ = false;
    consecutive_overruns_ = 0;
    expired_ns_ = 0;
    ClearWindows();
  }

  void Step() {
    const uint64_t missed = random_axis_.Disturb();
    before_ = axis_.status;
    const bool was_enabled = axis_.drive.enabled;
    const int32_t acting_before = axis_.drive.acting_counts;
    tick_number_ += 1 + missed;
    axis_.now_ns += static_cast<int64_t>(1 + missed) * axis_.period_ns;
    tick_->ReportLoopDelay(random_axis_.loop_delay_ns);
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
    CheckTrouble(was_enabled);
    CheckArming();
    CheckSlew(acting_before);
    CheckOverruns(missed);
    CheckWindows(missed);
    ++seen_states[static_cast<std::size_t>(axis_.status.state)];
    ++seen_faults[static_cast<std::size_t>(axis_.status.fault.fault)];
  }

  std::array<uint64_t, 4> seen_states{};
  std::array<uint64_t, 19> seen_faults{};
  uint64_t full_rampings = 0;
  uint64_t armed_late = 0;
  uint64_t arming_taken_back = 0;
  uint64_t rendered_with_another_filter = 0;

 private:
  // A force only while rendering, or within the ramp of a fault; within its limit; and no drive enabled
  // otherwise.
  void CheckForce() {
    const State state = axis_.status.state;
    if (state == State::kFault && before_.state != State::kFault) {
      latched_tick_ = tick_number_;
    }
    if (axis_.sample.mass == 0) {
      ASSERT_EQ(axis_.sample.force_counts, 0);
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
    if (began && !ending && arming_) {
      ++armed_late;
    }
    if ((!ending && !axis_.drive.arming) || axis_.status.state == State::kFault) {
      forfeited_epoch_ = settings.render_epoch;
    }
    const bool ended = axis_.status.renderings_ended != before_.renderings_ended;
    const bool rendered = before_.state == State::kRendering || began;
    ASSERT_EQ(ended, rendered && axis_.status.state != State::kRendering);
  }

  // The mass lies between zero and the masses that were set since rendering began, and within what is
  // admitted for the filter that runs, also on every ramp and every change of the filter.
  void CheckMass() {
    if (before_.state != State::kRendering && before_.state != State::kFault) {
      lowest_mass_ = highest_mass_ = 0;
    }
    // A tick may still set out for a mass and then find a reason to end.
    const bool ended = axis_.status.renderings_ended != before_.renderings_ended;
    if (std::isfinite(axis_.settings.mass) && (ended || axis_.status.target_mass == axis_.settings.mass)) {
      lowest_mass_ = std::min(lowest_mass_, axis_.settings.mass);
      highest_mass_ = std::max(highest_mass_, axis_.settings.mass);
    }
    ASSERT_TRUE(std::isfinite(axis_.sample.mass));
    ASSERT_GE(axis_.sample.mass, lowest_mass_);
    ASSERT_LE(axis_.sample.mass, highest_mass_);
    const auto* admitted =
        std::find_if(kAdmittedFilters.begin(), kAdmittedFilters.end(),
                     [this](const AdmittedFilter& each) { return each.filter == axis_.sample.filter; });
    ASSERT_NE(admitted, kAdmittedFilters.end());
    ASSERT_GE(axis_.sample.mass, admitted->min_mass);
    ASSERT_LE(axis_.sample.mass, admitted->max_mass);
    if (axis_.sample.mass != 0 && admitted != kAdmittedFilters.begin()) {
      ++rendered_with_another_filter;
    }
    if (axis_.sample.mass != 0 && axis_.sample.mass == axis_.settings.mass) {
      ++full_rampings;
    }
  }

  // A fault stays until it is cleared, and only an emergency stop takes its place.
  void CheckFault() const {
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

  // A drive that is enabled and in trouble has no force.
  void CheckTrouble(bool was_enabled) const {
    if (was_enabled && axis_.drive.trouble != device::DriveTrouble::kNone) {
      ASSERT_EQ(axis_.drive.acting_counts, 0);
      ASSERT_EQ(axis_.status.state, State::kFault);
    }
  }

  // A drive is on its way only while a start is wanted, and not for ever.
  void CheckArming() {
    if (axis_.drive.arming) {
      ASSERT_EQ(axis_.status.state, State::kIdle);
      ASSERT_TRUE(axis_.settings.rendering);
      ASSERT_GT(axis_.settings.lease_deadline_ns, axis_.now_ns);
      arming_since_ns_ = arming_ ? arming_since_ns_ : axis_.now_ns;
      ASSERT_LE(axis_.now_ns - arming_since_ns_, 100'000'000);
    } else if (arming_ && axis_.status.state == State::kIdle) {
      ++arming_taken_back;
    }
    arming_ = axis_.drive.arming;
  }

  // The force changes no faster than its limit, except to zero where the mass is.
  void CheckSlew(int32_t acting_before) const {
    if (axis_.sample.mass != 0) {
      const double step =
          std::abs(axis_.sample.force_counts - acting_before) * axis_.drive.info.force_quantum;
      ASSERT_LE(step, axis_.config.force_slew_limit * axis_.config.period_s + 1e-9);
    }
  }

  // Three ticks in a row may miss deadlines, and five deadlines at once.
  void CheckOverruns(uint64_t missed) {
    consecutive_overruns_ = missed > 0 ? consecutive_overruns_ + 1 : 0;
    if (consecutive_overruns_ > 3 || missed > 5) {
      ASSERT_NE(axis_.status.state, State::kRendering);
      ASSERT_EQ(axis_.drive.acting_counts, 0);
    }
  }

  // What was too much has ended the rendering.
  void CheckWindows(uint64_t missed) {
    if (axis_.status.state != State::kRendering) {
      ClearWindows();
      return;
    }
    if (before_.state == State::kRendering) {
      gaps_.Pass(missed, true);
      late_.Pass(missed + 1, random_axis_.loop_delay_ns > 1'000'000);
      saturation_.Pass(missed, last_.saturated);
      slew_.Pass(missed, last_.slew_limited);
    }
    last_ = axis_.sample;
    gaps_.Pass(1, !axis_.drive.answers_reads || !axis_.drive.takes_writes);
    saturation_.Pass(1, axis_.sample.saturated);
    slew_.Pass(1, axis_.sample.slew_limited);
    for (const ExactWindow* window : {&saturation_, &slew_, &gaps_, &late_}) {
      ASSERT_FALSE(window->Exceeded());
    }
  }
  void ClearWindows() {
    for (ExactWindow* window : {&saturation_, &slew_, &gaps_, &late_}) {
      window->Clear();
    }
  }

  RandomAxis random_axis_;
  Axis& axis_ = random_axis_.axis;
  std::optional<Tick> tick_;
  LoopStatus before_;
  exchange::Sample last_;
  uint64_t tick_number_ = 0;
  uint64_t forfeited_epoch_ = 0;
  uint64_t emergency_stops_obeyed_ = 0;
  uint64_t latched_tick_ = 0;
  uint64_t silence_ = 0;
  int64_t expired_ns_ = 0;
  int64_t arming_since_ns_ = 0;
  bool arming_ = false;
  double lowest_mass_ = 0;
  double highest_mass_ = 0;
  uint64_t consecutive_overruns_ = 0;
  ExactWindow saturation_{10};
  ExactWindow slew_{10};
  ExactWindow gaps_{15};
  ExactWindow late_{10};
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
  for (const uint64_t& count : history.seen_faults) {
    EXPECT_GT(count, kHistories / 100) << (&count - history.seen_faults.data());
  }
  EXPECT_GT(history.full_rampings, kHistories);
  EXPECT_GT(history.armed_late, kHistories / 100);
  EXPECT_GT(history.arming_taken_back, kHistories / 100);
  EXPECT_GT(history.rendered_with_another_filter, kHistories);
}

}  // namespace
}  // namespace mwidth::render
