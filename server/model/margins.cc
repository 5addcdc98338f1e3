#include "server/model/margins.h"

#include <cmath>
#include <complex>
#include <cstddef>
#include <limits>
#include <numbers>
#include <span>
#include <stdexcept>
#include <vector>

#include "server/model/accelerometer.h"
#include "server/model/delay_margin.h"
#include "server/model/delay_margin_search.h"
#include "server/model/level_set.h"
#include "server/model/open_loop.h"
#include "server/model/plant.h"
#include "server/model/unit_circle.h"

namespace mwidth::model {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Margin PhaseMargin(const OpenLoop& open, std::span<const OpenLoopOnArc> arcs, double period_s) {
  const SizeQuotient loop_gain{arcs, &OpenLoopOnArc::top_squared, &OpenLoopOnArc::bottom_squared,
                               [&open](double s) {
                                 const OpenLoopValue value = open.At(s);
                                 return SizePair{std::norm(value.top), std::norm(value.bottom)};
                               }};
  Margin worst{.value = kInfinity};
  for (const double s : LevelRoots(loop_gain, 1)) {
    const double angle = std::abs(std::arg(-open.Ratio(s)));
    if (angle < worst.value) {
      worst = {.value = angle, .critical_hz = FrequencyHz(s, period_s)};
    }
  }
  return worst;
}

// The least |1 + L| is where 1/|1 + L| is highest.
Margin ModulusMargin(const OpenLoop& open, std::span<const OpenLoopOnArc> arcs, double likely_hz,
                     double period_s) {
  constexpr double kTolerance = 1e-13;
  const SizeQuotient sensitivity{
      arcs, &OpenLoopOnArc::bottom_squared, &OpenLoopOnArc::sum_squared, [&open](double s) {
        if (s == 0) {
          return SizePair{1, std::norm(1.0 + open.Ratio(0))};
        }
        const OpenLoopValue value = open.At(s);
        return SizePair{std::norm(value.bottom), std::norm(value.top + value.bottom)};
      }};
  const double half_sine = std::sin(std::numbers::pi * likely_hz * period_s);
  const Peak peak = HighestRatio(sensitivity, half_sine * half_sine, kTolerance);
  return {.value = 1 / std::sqrt(peak.ratio), .critical_hz = FrequencyHz(peak.half_sine_squared, period_s)};
}

// Keeps the smaller of two margins; true where that is the new one.
bool Lower(Margin& worst, const Margin& margin) {
  const bool lower = margin.value < worst.value;
  worst = lower ? margin : worst;
  return lower;
}

OpenLoop SensedLoop(const LoopParameters& loop, double mass) {
  const SampledPlant plant = Discretize(loop);
  return {plant, DiscretizeAcceleration(loop, plant), AccelerometerFilter(loop),
          loop.device_mass + loop.hand_mass, mass};
}

// `open` and `delay` are asked only where the mass is inside the M-width and not 0.
template <typename Open, typename Delay>
Margins MarginsOf(const LoopParameters& loop, const MWidth& m_width, double mass, const Open& open_loop,
                  const Delay& delay) {
  Margins margins;
  margins.stable = m_width.Contains(mass);
  margins.gain.value = GainMargin(m_width, mass);
  if (m_width.empty()) {
    return margins;
  }
  if (mass == 0) {
    margins.phase_rad.value = margins.delay.seconds = kInfinity;
    margins.modulus.value = 1;
    return margins;
  }
  margins.gain.critical_hz = (mass > 0 ? m_width.upper : m_width.lower).critical_hz;
  if (margins.stable) {
    const OpenLoop open = open_loop();
    const std::vector<OpenLoopOnArc> arcs = open.Arcs();
    // Near an edge L comes nearest to -1 at the frequency of that edge.
    const double likely_hz = margins.gain.critical_hz;
    margins.phase_rad = PhaseMargin(open, arcs, loop.period_s);
    margins.delay = delay(likely_hz);
    margins.modulus = ModulusMargin(open, arcs, likely_hz, loop.period_s);
  }
  return margins;
}

}  // namespace

Margins ComputeMargins(const LoopParameters& loop, double mass) {
  const MWidth m_width = ComputeMWidth(loop);
  if (IsAccelerometer(loop.estimator)) {
    return MarginsOf(
        loop, m_width, mass, [&] { return SensedLoop(loop, mass); },
        [&](double) { return SearchDelayMargin(loop, mass); });
  }
  return ComputeMargins(loop, EstimatorOf(loop), m_width, mass);
}

Margins ComputeMargins(const LoopParameters& loop, const LinearEstimator& estimator, const MWidth& m_width,
                       double mass) {
  return MarginsOf(
      loop, m_width, mass, [&] { return OpenLoop(Discretize(loop), estimator, mass); },
      [&](double likely_hz) { return ComputeDelayMargin(loop, estimator, mass, likely_hz); });
}

WorstMargins WorstMarginsAmong(std::span<const LoopParameters> loops, double mass) {
  if (loops.empty()) {
    throw std::invalid_argument("the worst of no loops is asked for");
  }
  WorstMargins worst{.margins = ComputeMargins(loops[0], mass)};
  for (std::size_t i = 1; i < loops.size(); ++i) {
    const Margins margins = ComputeMargins(loops[i], mass);
    worst.margins.stable = worst.margins.stable && margins.stable;
    worst.gain_loop = Lower(worst.margins.gain, margins.gain) ? i : worst.gain_loop;
    worst.phase_loop = Lower(worst.margins.phase_rad, margins.phase_rad) ? i : worst.phase_loop;
    worst.modulus_loop = Lower(worst.margins.modulus, margins.modulus) ? i : worst.modulus_loop;
    if (margins.delay.seconds < worst.margins.delay.seconds) {
      worst.margins.delay = margins.delay;
      worst.delay_loop = i;
    }
  }
  return worst;
}

}  // namespace mwidth::model
