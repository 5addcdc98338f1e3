#include "server/render/hand_monitor.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace mwidth::render {
namespace {

// A turn of the acceleration counts once it has come back by this part of its last swing, and of the least
// one: what the encoder's counts put on top of an oscillation is not a turn.
constexpr double kTurnShare = 0.2;

// The swing, in parts of the force limit, at which twice as much of the motion may be unexplained: whoever
// moves that hard by will does so for a moment, and such a moment is what no mode explains.
constexpr double kLoudSwing = 0.25;
constexpr double kMostUnexplained = 0.2;

// What a motion e^(st) obeys, j + beta a + kappa v = 0, where a and j are backward differences per period T.
struct Mode {
  double beta = 0;
  double kappa = 0;
  // What is left of j, in parts of its variance.
  double unexplained = 1;

  bool oscillates() const noexcept { return 4 * kappa > beta * beta; }
  // e^(sT) = 1/(1 - delta T) with delta^2 + beta delta + kappa = 0: its angle, and the logarithm of its size.
  double Angle(double period_s) const noexcept {
    return std::atan2(period_s * std::sqrt(kappa - beta * beta / 4), 1 + period_s * beta / 2);
  }
  double LogSize(double period_s) const noexcept {
    return -0.5 * std::log1p(period_s * (beta + period_s * kappa));
  }
};

// The mode that leaves the least of j.
Mode FitMode(double jj, double ja, double jv, double aa, double av, double vv) noexcept {
  const double determinant = aa * vv - av * av;
  if (!(determinant > 0) || !(jj > 0)) {
    return {};
  }
  Mode mode;
  mode.beta = (jv * av - ja * vv) / determinant;
  mode.kappa = (ja * av - jv * aa) / determinant;
  mode.unexplained = (jj + mode.beta * ja + mode.kappa * jv) / jj;
  return mode;
}

}  // namespace

HandMonitor::Moments& HandMonitor::Moments::operator+=(const Moments& other) noexcept {
  count += other.count;
  v += other.v;
  a += other.a;
  j += other.j;
  force += other.force;
  vv += other.vv;
  av += other.av;
  aa += other.aa;
  jv += other.jv;
  ja += other.ja;
  jj += other.jj;
  force_v += other.force_v;
  return *this;
}

HandMonitor::Moments HandMonitor::Moments::Centred() const noexcept {
  Moments centred = *this;
  centred.vv -= v * v / count;
  centred.av -= a * v / count;
  centred.aa -= a * a / count;
  centred.jv -= j * v / count;
  centred.ja -= j * a / count;
  centred.jj -= j * j / count;
  centred.force_v -= force * v / count;
  return centred;
}

double HandMonitor::LowPass::Update(double input, double gain) noexcept {
  for (double& stage : stages) {
    stage += gain * (input - stage);
    input = stage;
  }
  return input;
}

HandMonitor::HandMonitor(const HandMonitorConfig& config, double period_s, double force_limit) noexcept
    : config_(config), period_s_(period_s), force_limit_(force_limit) {}

void HandMonitor::SetCriticalHz(double critical_hz) noexcept {
  if (critical_hz == critical_hz_) {
    return;
  }
  critical_hz_ = critical_hz;
  gain_ = -std::expm1(-2 * std::numbers::pi * kHighestCriticalShare * critical_hz * period_s_);
  watching_ = false;
}

HandVerdict HandMonitor::Step(const HandObservation& seen) noexcept {
  if (!config_.enabled || !(critical_hz_ > 0) || !(seen.mass < 0)) {
    watching_ = false;
    return {};
  }
  if (!watching_ || seen.periods > kLongestGap) {
    Begin(seen.velocity);
    return {};
  }
  const double least_turn = kTurnShare * config_.min_swing * force_limit_ / -seen.mass;
  HandVerdict verdict;
  // Over a gap the velocity is the mean one, and the force acted on.
  for (uint64_t period = 0; period < seen.periods; ++period) {
    Pass(seen.velocity, seen.force);
    if (Turned(least_turn) && verdict.kind == HandVerdict::Kind::kCertified) {
      verdict = Judge(seen.mass);
    }
  }
  watching_ = verdict.kind == HandVerdict::Kind::kCertified;
  return verdict;
}

void HandMonitor::Begin(double velocity) noexcept {
  watching_ = true;
  velocity_.stages.fill(velocity);
  force_.stages.fill(0);
  v_ = velocity;
  a_ = turning_point_ = extremum_ = 0;
  rising_ = true;
  turned_before_ = false;
  now_ = {};
  half_cycle_count_ = 0;
}

void HandMonitor::Pass(double velocity, double force) noexcept {
  const double v = velocity_.Update(velocity, gain_);
  // The same filter for both keeps the phase between them, which is the work.
  const double f = force_.Update(force, gain_);
  const double a = (v - v_) / period_s_;
  const double j = (a - a_) / period_s_;
  v_ = v;
  a_ = a;
  now_ += {.count = 1,
           .v = v,
           .a = a,
           .j = j,
           .force = f,
           .vv = v * v,
           .av = a * v,
           .aa = a * a,
           .jv = j * v,
           .ja = j * a,
           .jj = j * j,
           .force_v = f * v};
}

bool HandMonitor::Turned(double least_turn) noexcept {
  const double way = rising_ ? 1 : -1;
  if ((a_ - extremum_) * way >= 0) {
    extremum_ = a_;
    return false;
  }
  const double swing = std::abs(extremum_ - turning_point_);
  if ((extremum_ - a_) * way <= std::max(least_turn, kTurnShare * swing)) {
    return false;
  }
  // What came before the first turning point is no whole half-cycle.
  if (turned_before_) {
    std::move_backward(half_cycles_.begin(), half_cycles_.end() - 1, half_cycles_.end());
    half_cycles_.front() = {.moments = now_, .swing = swing};
    half_cycle_count_ = std::min(half_cycle_count_ + 1, kMostHalfCycles);
  }
  turned_before_ = true;
  now_ = {};
  turning_point_ = extremum_;
  extremum_ = a_;
  rising_ = !rising_;
  return true;
}

HandVerdict HandMonitor::Judge(double mass) const noexcept {
  const double swing = half_cycles_.front().swing * -mass / force_limit_;
  if (!(swing >= config_.min_swing)) {
    return {};
  }
  HandVerdict verdict;
  Moments sums;
  for (std::size_t i = 0; i < half_cycle_count_ && verdict.kind == HandVerdict::Kind::kCertified; ++i) {
    sums += half_cycles_[i].moments;
    if (i + 1 >= kFewestHalfCycles) {
      verdict = JudgeOver(i + 1, sums.Centred(), swing);
    }
  }
  return verdict;
}

HandVerdict HandMonitor::JudgeOver(std::size_t half_cycles, const Moments& sums,
                                   double swing) const noexcept {
  const Mode mode = FitMode(sums.jj, sums.ja, sums.jv, sums.aa, sums.av, sums.vv);
  if (!mode.oscillates()) {
    return {};
  }
  const double angle = mode.Angle(period_s_);
  HandVerdict verdict{.frequency_hz = angle / (2 * std::numbers::pi * period_s_),
                      .swing = swing * force_limit_};
  if (verdict.frequency_hz < kLowestCriticalShare * critical_hz_ ||
      verdict.frequency_hz > kHighestCriticalShare * critical_hz_) {
    return {};
  }
  // Powers, as the damping that would take them: what the rendered force puts in, and what of it neither the
  // device nor the growth of the kinetic energy uses up, so that it went into the hand.
  const double put_in = -sums.force_v / sums.vv;
  // a v less T/2 a^2 is what v^2/2 grows by, exactly: the backward difference leads the velocity by half a
  // period.
  const double kinetic = config_.device_mass * (sums.av - period_s_ / 2 * sums.aa) / sums.vv;
  const double into_hand = put_in - config_.device_damping - kinetic;
  const double growth = std::exp(mode.LogSize(period_s_) * 2 * std::numbers::pi / angle);
  const double most_put_in = config_.max_energy_ratio * config_.least_damping;
  if (swing >= config_.energy_swing && put_in > most_put_in) {
    verdict.kind = HandVerdict::Kind::kEnergyExcess;
    verdict.value = put_in;
    verdict.limit = most_put_in;
  } else if (put_in > 0 && into_hand > -config_.max_push * config_.least_damping &&
             Grows(half_cycles, mode.unexplained, growth, swing)) {
    verdict.kind = HandVerdict::Kind::kGrowingOscillation;
    verdict.value = growth;
    verdict.limit = config_.min_growth;
  }
  return verdict;
}

bool HandMonitor::Grows(std::size_t half_cycles, double unexplained, double growth,
                        double swing) const noexcept {
  const auto beyond_second = static_cast<double>(half_cycles - 2);
  const double loudness = swing / kLoudSwing;
  return growth > config_.min_growth &&
         unexplained <
             std::min(kMostUnexplained, beyond_second * config_.max_unexplained * (1 + loudness * loudness));
}

}  // namespace mwidth::render
