#include "server/model/m_width.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "server/model/accelerometer.h"
#include "server/model/crossing.h"
#include "server/model/estimator.h"
#include "server/model/plant.h"
#include "server/model/unit_circle.h"

namespace mwidth::model {
namespace {

constexpr double kLowestCutoffHz = 0.1;

Crossings CrossingsOf(const LoopParameters& loop, const SampledPlant& plant) noexcept {
  const double moving_mass = loop.device_mass + loop.hand_mass;
  if (IsAccelerometer(loop.estimator)) {
    const SampledAcceleration acceleration = DiscretizeAcceleration(loop, plant);
    return FindCrossings(plant, acceleration, AccelerometerFactors(loop, acceleration), moving_mass);
  }
  return FindCrossings(plant, FactorsOf(loop.estimator, loop.period_s, loop.cutoff_hz), moving_mass);
}

}  // namespace

MWidth ComputeMWidth(const LoopParameters& loop) {
  MWidth m_width;
  const SampledPlant plant = Discretize(loop);
  if (plant.loss == 0 && loop.hand_stiffness > 0) {
    m_width.empty_reason =
        "without damping (device_damping and hand_damping are 0) the hand's spring and the mass swing for "
        "ever, "
        "whatever mass is rendered";
    return m_width;
  }
  // A rising mass, and a falling one, first meets the crossing nearest to 0 on its side. There is one on
  // each: behind a hold the loop's numerator is below its denominator by one degree or more, whatever the
  // estimator, so a large enough mass of either sign drives a root to infinity. An accelerometer that tells
  // nothing, because damping leaves nothing to tell within a tick, has infinite edges.
  Crossing lower{.mass = -std::numeric_limits<double>::infinity()};
  Crossing upper{.mass = std::numeric_limits<double>::infinity()};
  for (const Crossing& crossing : CrossingsOf(loop, plant)) {
    if (crossing.mass > 0 && crossing.mass < upper.mass) {
      upper = crossing;
    } else if (crossing.mass < 0 && crossing.mass > lower.mass) {
      lower = crossing;
    }
  }
  m_width.lower = {.mass = lower.mass, .critical_hz = FrequencyHz(lower.half_sine_squared, loop.period_s)};
  m_width.upper = {.mass = upper.mass, .critical_hz = FrequencyHz(upper.half_sine_squared, loop.period_s)};
  return m_width;
}

double GainMargin(const MWidth& m_width, double mass) {
  if (m_width.empty() || std::isnan(mass)) {
    return 0;
  }
  if (mass == 0) {
    return std::numeric_limits<double>::infinity();
  }
  return (mass > 0 ? m_width.upper.mass : m_width.lower.mass) / mass;
}

std::optional<double> HighestAdmittingCutoffHz(double highest_hz, const std::function<bool(double)>& admits) {
  double refused = highest_hz;
  if (admits(refused)) {
    return refused;
  }
  // An edge need not move one way with the cut-off: the search goes down until the mass is inside.
  constexpr double kStep = 0.97;
  double admitted = refused;
  do {
    if (admitted <= kLowestCutoffHz) {
      return std::nullopt;
    }
    refused = admitted;
    admitted = std::fmax(refused * kStep, kLowestCutoffHz);
  } while (!admits(admitted));
  while (refused - admitted > 1e-7 * admitted) {
    const double middle = admitted + (refused - admitted) / 2;
    (admits(middle) ? admitted : refused) = middle;
  }
  return admitted;
}

std::optional<double> HighestAdmittingCutoffHz(const LoopParameters& loop, double mass, double gain_margin) {
  return HighestAdmittingCutoffHz(loop.cutoff_hz, [&](double cutoff_hz) {
    LoopParameters candidate = loop;
    candidate.cutoff_hz = cutoff_hz;
    return ComputeMWidth(candidate).Contains(mass * gain_margin);
  });
}

}  // namespace mwidth::model
