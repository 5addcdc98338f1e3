#include "server/model/m_width.h"

#include <cmath>
#include <limits>

#include "server/model/accelerometer.h"
#include "server/model/crossing.h"
#include "server/model/edge_crossing.h"
#include "server/model/estimator.h"
#include "server/model/plant.h"
#include "server/model/unit_circle.h"

namespace mwidth::model {
namespace {

constexpr double kLowestCutoffHz = 0.1;

// None where not even M = 0 is stable.
std::optional<EdgeCrossings> CrossingsAtTheEdges(const LoopParameters& loop) noexcept {
  const SampledPlant plant = Discretize(loop);
  if (plant.loss == 0 && loop.hand_stiffness > 0) {
    return std::nullopt;
  }
  const double moving_mass = loop.device_mass + loop.hand_mass;
  if (IsAccelerometer(loop.estimator)) {
    const SampledAcceleration acceleration = DiscretizeAcceleration(loop, plant);
    return NearestToZero(
        FindCrossings(plant, acceleration, AccelerometerFactors(loop, acceleration), moving_mass));
  }
  return FindEdgeCrossings(plant, FactorsOf(loop.estimator, loop.period_s, loop.cutoff_hz), moving_mass);
}

Edge EdgeAt(const Crossing& crossing, double period_s) noexcept {
  return {.mass = crossing.mass, .critical_hz = FrequencyHz(crossing.half_sine_squared, period_s)};
}

}  // namespace

MWidth ComputeMWidth(const LoopParameters& loop) {
  MWidth m_width;
  if (const auto crossings = CrossingsAtTheEdges(loop)) {
    m_width.lower = EdgeAt(crossings->lower, loop.period_s);
    m_width.upper = EdgeAt(crossings->upper, loop.period_s);
  } else {
    m_width.empty_reason =
        "without damping (device_damping and hand_damping are 0) the hand's spring and the mass swing for "
        "ever, whatever mass is rendered";
  }
  return m_width;
}

EdgeMasses ComputeEdgeMasses(const LoopParameters& loop) noexcept {
  const auto crossings = CrossingsAtTheEdges(loop);
  return crossings ? EdgeMasses{.lower = crossings->lower.mass, .upper = crossings->upper.mass}
                   : EdgeMasses{};
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
    return ComputeEdgeMasses(candidate).Contain(mass * gain_margin);
  });
}

}  // namespace mwidth::model
