#include "server/model/delay_margin.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "server/model/level_set.h"
#include "server/model/open_loop.h"
#include "server/model/plant.h"
#include "server/model/unit_circle.h"

namespace mwidth::model {
namespace {

using Complex = std::complex<double>;

// R is proven to this share.
constexpr double kTolerance = 1e-3;
// What may be left without proof before a crossing, relative to its delay.
constexpr double kLeft = 1e-5;
// So near to -1 the squares of distances, expanded, are about to drown in rounding.
constexpr double kCloseToCritical = 1e-6;
// How much longer than the safe step the way from there to the crossing may be.
constexpr double kStretch = 1e3;

// An extra delay in periods, and an angle t of the circle.
struct DelayPoint {
  double ticks = 0;
  double angle = 0;
};

// One mass in one loop, later and later.
class DelayedLoop {
 public:
  DelayedLoop(const LoopParameters& loop, const LinearEstimator& estimator, double mass)
      : loop_(loop), estimator_(estimator), mass_(mass) {}

  // Extra delays beyond the supported range are cut off.
  OpenLoop After(double ticks) const {
    LoopParameters delayed = loop_;
    delayed.delay_s = std::clamp(loop_.delay_s + ticks * loop_.period_s, 0.0, 3 * loop_.period_s);
    return {Discretize(delayed), estimator_, mass_};
  }

  // Supported extra delay in periods.
  double Range() const { return 3 - loop_.delay_s / loop_.period_s; }

  // At most how far the mass stays behind, per tick by which a step of the force is later (delay_margin.h).
  double Reach() const {
    const double mass = loop_.device_mass + loop_.hand_mass;
    const double damping = (loop_.device_damping + loop_.hand_damping) * loop_.period_s / mass;
    const double stiffness = loop_.hand_stiffness * loop_.period_s * loop_.period_s / mass;
    return std::min({1.0, 2 / damping, 2 / std::sqrt(stiffness)});
  }

  // A resonance narrower than this share of its frequency lies between the numbers of double precision.
  bool IsResolved() const {
    const double damping = loop_.device_damping + loop_.hand_damping;
    const double stiffness = loop_.hand_stiffness * (loop_.device_mass + loop_.hand_mass);
    return damping >= 2e-9 * std::sqrt(stiffness);
  }

  // The crossing near `from`, by Newton's method in its two unknowns; anything where it does not converge.
  DelayPoint Refine(DelayPoint from) const;

  bool IsCrossing(const DelayPoint& at) const { return std::abs(FromCritical(at.ticks, at.angle)) < 1e-9; }

  DelayMargin Crossing(const DelayPoint& at) const {
    const double upper_half = std::numbers::pi - std::abs(std::numbers::pi - at.angle);
    return {.seconds = at.ticks * loop_.period_s,
            .critical_hz = upper_half / (2 * std::numbers::pi * loop_.period_s)};
  }
  DelayMargin AtLeast(double ticks) const { return {.seconds = ticks * loop_.period_s, .at_least = true}; }

 private:
  // 1 + L. Beyond t = pi the circle goes on in the lower half, where L is the conjugate.
  Complex FromCritical(double ticks, double angle) const {
    const double half_sine = std::sin(angle / 2);
    const Complex ratio = After(ticks).Ratio(half_sine * half_sine);
    return 1.0 + (angle > std::numbers::pi ? std::conj(ratio) : ratio);
  }

  LoopParameters loop_;
  const LinearEstimator& estimator_;
  double mass_;
};

DelayPoint DelayedLoop::Refine(DelayPoint from) const {
  constexpr int kMaxIterations = 30;
  // Differences, for the slopes: of a tick, and of a frequency, which must be small against a resonance's
  // width.
  constexpr double kLater = 1e-6;
  constexpr double kHigher = 1e-8;
  for (int i = 0; i < kMaxIterations; ++i) {
    const auto [ticks, angle] = from;
    const Complex value = FromCritical(ticks, angle);
    const Complex by_ticks =
        (FromCritical(ticks + kLater, angle) - FromCritical(ticks - kLater, angle)) / (2 * kLater);
    const Complex by_angle =
        (FromCritical(ticks, angle * (1 + kHigher)) - FromCritical(ticks, angle * (1 - kHigher))) /
        (2 * kHigher * angle);
    const double area = std::imag(std::conj(by_ticks) * by_angle);
    const double later = -std::imag(std::conj(value) * by_angle) / area;
    from = {.ticks = ticks + later, .angle = angle - std::imag(std::conj(by_ticks) * value) / area};
    if (!(std::abs(later) > 1e-14 * std::abs(from.ticks))) {
      break;
    }
  }
  return from;
}

// Where a mass between 0 and the loop's own has a root on the circle: L real and at most -1. At z = -1 it is
// the loop's own mass that has one first.
std::optional<double> CrossingOfSmallerMass(const OpenLoop& open, std::span<const OpenLoopOnArc> arcs) {
  for (const OpenLoopOnArc& on : arcs) {
    const ArcForm slope = Derivative(on.imaginary);
    for (const RootBracket& bracket : IsolateRoots(on.imaginary)) {
      const double s = on.arc.HalfSineSquared(RefineRoot(bracket, [&](double x) {
        return ValueAndSlope{Evaluate(on.imaginary, x), Evaluate(slope, x)};
      }));
      if (open.Ratio(s).real() <= -1) {
        return AngleAt(s);
      }
    }
  }
  return std::nullopt;
}

// The delay between `inside` and `outside` from which on a smaller mass crosses.
DelayPoint FirstCrossingOfSmallerMass(const DelayedLoop& loop, double inside, DelayPoint outside) {
  while (outside.ticks - inside > 1e-14 * outside.ticks) {
    const double middle = inside + (outside.ticks - inside) / 2;
    if (middle <= inside || middle >= outside.ticks) {
      break;
    }
    const OpenLoop open = loop.After(middle);
    const std::optional<double> angle = CrossingOfSmallerMass(open, open.Arcs());
    if (angle) {
      outside = {.ticks = middle, .angle = *angle};
    } else {
      inside = middle;
    }
  }
  return {.ticks = inside, .angle = outside.angle};
}

// How many ticks later L provably stays away from -1, and where it comes nearest.
struct SafeStep {
  DelayPoint to;
  double distance = 0;
};

SafeStep StepFrom(double ticks, const OpenLoop& open, std::span<const OpenLoopOnArc> arcs, double reach,
                  double guess) {
  const auto sizes = [&open](double s) {
    const OpenLoopValue value = open.At(s);
    const double step = open.StepSize(s);
    return s == 0 ? SizePair{0, 1} : SizePair{step * step, std::norm(value.top + value.bottom)};
  };
  const SizeQuotient quotient{arcs, &OpenLoopOnArc::step_squared, &OpenLoopOnArc::sum_squared, sizes};
  const double half_sine = std::sin(guess / 2);
  const Peak peak = HighestRatio(quotient, half_sine * half_sine, kTolerance);
  const double step = 1 / (reach * std::sqrt(peak.ratio * (1 + kTolerance)));
  return {.to = {.ticks = ticks + step, .angle = AngleAt(peak.half_sine_squared)},
          .distance = std::abs(1.0 + open.Ratio(peak.half_sine_squared))};
}

}  // namespace

DelayMargin ComputeDelayMargin(const LoopParameters& loop, const LinearEstimator& estimator, double mass,
                               double likely_hz) {
  const DelayedLoop delayed(loop, estimator, mass);
  if (!delayed.IsResolved()) {
    return delayed.AtLeast(0);
  }
  const double reach = delayed.Reach();
  const double range = delayed.Range();
  constexpr int kMaxSteps = 4000;
  double before = 0;
  double proven = 0;
  double guess = 2 * std::numbers::pi * likely_hz * loop.period_s;
  for (int i = 0; i < kMaxSteps; ++i) {
    const OpenLoop open = delayed.After(proven);
    const std::vector<OpenLoopOnArc> arcs = open.Arcs();
    if (const std::optional<double> angle = CrossingOfSmallerMass(open, arcs)) {
      return delayed.Crossing(
          FirstCrossingOfSmallerMass(delayed, before, {.ticks = proven, .angle = *angle}));
    }
    const SafeStep step = StepFrom(proven, open, arcs, reach, guess);
    const bool close = step.distance < kCloseToCritical;
    const double way = step.to.ticks - proven;
    if (close || way < kLeft * proven) {
      const DelayPoint crossing = delayed.Refine(step.to);
      const double left = crossing.ticks - proven;
      if (left >= 0 && left <= (close ? kStretch * way : kLeft * proven) && delayed.IsCrossing(crossing)) {
        return delayed.Crossing(crossing);
      }
      if (close) {
        return delayed.AtLeast(proven);
      }
    }
    if (step.to.ticks >= range) {
      return delayed.AtLeast(step.to.ticks);
    }
    before = proven;
    proven = step.to.ticks;
    guess = step.to.angle;
  }
  return delayed.AtLeast(proven);
}

}  // namespace mwidth::model
