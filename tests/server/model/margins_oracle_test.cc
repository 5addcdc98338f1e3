// Phase and modulus margins against the open loop itself, on dense grids and in 50 digits.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <vector>

#include "server/model/margins.h"
#include "tests/server/model/model_loops.h"
#include "tests/server/model/reference_open_loop.h"

namespace mwidth::model {
namespace {

using Fine = long double;

struct Case {
  LoopParameters loop;
  double mass;
};

// Masses from a thousandth of an edge to 0.999 of it, hands and estimators of all kinds.
std::vector<Case> Cases(int count) {
  RandomLoops random(41);
  std::vector<Case> cases;
  for (int i = 0; i < count; ++i) {
    LoopParameters loop = random.Next();
    loop.hand_stiffness = i % 9 == 3 ? 0 : loop.hand_stiffness;
    loop.estimator = kAllEstimatorKinds.at(static_cast<std::size_t>(i) / 2 % kAllEstimatorKinds.size());
    loop.accelerometer_bandwidth_hz = random.LogUniform(0.01, 5) / loop.period_s;
    const MWidth m_width = ComputeMWidth(loop);
    const double share = i % 2 == 0 ? 1 - random.LogUniform(1e-3, 1) : random.LogUniform(1e-3, 1);
    cases.push_back({loop, share * (random.Uniform(0, 1) < 0.5 ? m_width.lower.mass : m_width.upper.mass)});
  }
  return cases;
}

// Angles all over the half circle, evenly and by decades, and more around the natural frequency.
std::vector<Fine> Grid(const LoopParameters& loop) {
  constexpr int kPoints = 3000;
  const Fine pi = std::numbers::pi_v<Fine>;
  const double rate = std::sqrt(loop.hand_stiffness / (loop.device_mass + loop.hand_mass));
  const Fine natural = std::min<Fine>(rate * loop.period_s, pi);
  std::vector<Fine> grid;
  for (int i = 1; i <= kPoints; ++i) {
    const Fine share = static_cast<Fine>(i) / kPoints;
    grid.push_back(pi * share);
    grid.push_back(pi * std::pow(Fine(1e-7), share));
    const Fine away = std::pow(Fine(1e-8), share) / 2;
    grid.push_back(natural * (1 + away));
    grid.push_back(natural * (1 - away));
  }
  std::sort(grid.begin(), grid.end());
  while (grid.back() > pi) {
    grid.pop_back();
  }
  return grid;
}

TEST(MarginsOracle, NoPointOfADenseGridIsNearerThanTheModulusMargin) {
  for (const auto& [loop, mass] : Cases(300)) {
    const ReferenceOpenLoop<Fine> reference(loop);
    const Margin modulus = ComputeMargins(loop, mass).modulus;
    Fine nearest = 1;
    for (const Fine& angle : Grid(loop)) {
      nearest = std::min(nearest, reference.Distance(mass, angle));
    }
    EXPECT_GE(nearest, modulus.value * (1 - 1e-9)) << mass;
  }
}

TEST(MarginsOracle, TheModulusMarginIsTakenAtItsFrequency) {
  for (const auto& [loop, mass] : Cases(300)) {
    const Margin modulus = ComputeMargins(loop, mass).modulus;
    if (modulus.critical_hz == 0) {
      EXPECT_EQ(modulus.value, 1);
      continue;
    }
    const ReferenceOpenLoop<Real> reference(loop);
    const Real angle = 2 * boost::math::constants::pi<Real>() * modulus.critical_hz * loop.period_s;
    EXPECT_NEAR(static_cast<double>(reference.Distance(mass, angle)), modulus.value, 1e-9 * modulus.value)
        << mass;
  }
}

TEST(MarginsOracle, ThePhaseMarginIsTakenAtItsFrequencyWhereTheGainIsOne) {
  int finite = 0;
  for (const auto& [loop, mass] : Cases(700)) {
    const Margin phase = ComputeMargins(loop, mass).phase_rad;
    if (std::isinf(phase.value)) {
      continue;
    }
    ++finite;
    const ReferenceOpenLoop<Real> reference(loop);
    const Real angle = 2 * boost::math::constants::pi<Real>() * phase.critical_hz * loop.period_s;
    // A frequency in double precision is off a sharp resonance by a share of its width.
    EXPECT_NEAR(static_cast<double>(reference.Gain(mass, angle)), 1, 1e-9) << mass;
    EXPECT_NEAR(static_cast<double>(reference.Phase(mass, angle)), phase.value, 1e-9) << mass;
  }
  EXPECT_GT(finite, 300);
}

// Every crossing that a grid finds, bisected.
Fine PhaseMarginByGrid(const ReferenceOpenLoop<Fine>& reference, double mass, const std::vector<Fine>& grid) {
  Fine worst = std::numeric_limits<Fine>::infinity();
  for (std::size_t i = 1; i < grid.size(); ++i) {
    Fine low = grid[i - 1];
    Fine high = grid[i];
    const bool above = reference.Gain(mass, low) > 1;
    if (above == (reference.Gain(mass, high) > 1)) {
      continue;
    }
    for (int k = 0; k < 60; ++k) {
      const Fine middle = (low + high) / 2;
      ((reference.Gain(mass, middle) > 1) == above ? low : high) = middle;
    }
    worst = std::min(worst, reference.Phase(mass, low));
  }
  return worst;
}

TEST(MarginsOracle, NoUnitGainCrossingIsMissed) {
  for (const auto& [loop, mass] : Cases(300)) {
    const ReferenceOpenLoop<Fine> reference(loop);
    const Fine by_grid = PhaseMarginByGrid(reference, mass, Grid(loop));
    const double phase = ComputeMargins(loop, mass).phase_rad.value;
    if (std::isinf(by_grid)) {
      // The grid may miss two crossings close together, not the other way round.
      continue;
    }
    EXPECT_LE(phase, by_grid * (1 + 1e-9) + 1e-12) << mass;
  }
}

}  // namespace
}  // namespace mwidth::model
