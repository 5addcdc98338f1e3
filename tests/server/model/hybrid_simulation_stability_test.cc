// The hybrid simulation with its loop closed decays just inside the M-width and grows just outside: eqs. 1 to
// 5 simulated, against the closed form of the edges, which knows nothing of the simulation.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "server/model/estimator.h"
#include "server/model/hybrid_simulation.h"
#include "server/model/m_width.h"
#include "tests/server/model/closed_loop_map.h"

namespace mwidth::model {
namespace {

constexpr double kInside = 0.999;
constexpr double kOutside = 1.001;
constexpr uint64_t kAnyTicks = 100'000'000;

/// Runs the loop tick by tick with a hand at rest, from a push, until the velocity has changed by a factor of
/// 1e8. `shown_within` is the ticks in which the slowest oscillation of interest shows its amplitude.
Verdict Watch(const LoopParameters& loop, double mass, uint64_t shown_within, uint64_t max_ticks) {
  constexpr double kDecided = 1e8;
  HybridSimulation simulation(loop);
  AccelerationEstimator estimator(loop.period_s, loop.cutoff_hz);
  simulation.Reset(0, 1, 0);
  double largest = 0;
  double smallest = 0;
  for (uint64_t tick = 0; tick < max_ticks;) {
    double amplitude = 0;
    for (const uint64_t shown = tick + shown_within; tick < shown; ++tick) {
      simulation.Command(mass * estimator.Update(simulation.position()));
      simulation.Advance(0);
      amplitude = std::max(amplitude, std::abs(simulation.velocity()));
    }
    largest = std::max(largest, amplitude);
    smallest = smallest == 0 ? amplitude : std::min(smallest, amplitude);
    if (amplitude < largest / kDecided) {
      return Verdict::kDecays;
    }
    if (amplitude > smallest * kDecided) {
      return Verdict::kGrows;
    }
  }
  return Verdict::kOpen;
}

uint64_t TicksPerOscillation(const Edge& edge, const LoopParameters& loop) {
  return static_cast<uint64_t>(std::ceil(1 / (edge.critical_hz * loop.period_s))) + 8;
}

/// Proves both sides of an edge; where that takes few enough ticks also runs them. Returns whether it ran
/// them.
bool ExpectStabilityToEndAt(const Edge& edge, const LoopParameters& loop, uint64_t max_ticks) {
  bool runs = true;
  for (const double detuning : {kInside, kOutside}) {
    const Verdict expected = detuning == kInside ? Verdict::kDecays : Verdict::kGrows;
    uint64_t ticks = 0;
    EXPECT_EQ(ClosedLoopMap(loop, detuning * edge.mass).Prove(ticks), expected) << detuning;
    runs = runs && ticks <= max_ticks;
    if (ticks <= max_ticks) {
      // A norm may fall below 1 long before the motion has faded.
      const uint64_t enough_ticks = 1000 * ticks;
      const uint64_t shown_within = TicksPerOscillation(edge, loop);
      EXPECT_EQ(Watch(loop, detuning * edge.mass, shown_within, enough_ticks), expected) << detuning;
    }
  }
  return runs;
}

LoopParameters PaperLoop() {
  return {.device_mass = 0.07,
          .device_damping = 0.005,
          .hand_damping = 5,
          .hand_stiffness = 700,
          .period_s = 1e-3,
          .cutoff_hz = 10};
}

/// The box over which the closed form must be exact.
LoopParameters RandomLoop(std::mt19937_64& random) {
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto log_uniform = [&](double low, double high) {
    return std::exp(uniform(std::log(low), std::log(high)));
  };
  LoopParameters loop;
  loop.device_mass = log_uniform(1e-3, 1e2);
  loop.device_damping = log_uniform(1e-4, 1e1);
  loop.hand_damping = log_uniform(1e-2, 3e2);
  loop.hand_stiffness = log_uniform(1, 3e4);
  loop.period_s = log_uniform(1e-5, 1e-2);
  loop.cutoff_hz = log_uniform(1e-3, 0.48) / loop.period_s;
  loop.delay_s = uniform(0, 1) < 0.4 ? 0 : uniform(0, 3) * loop.period_s;
  return loop;
}

TEST(HybridSimulationStability, EndsAtTheEdgesOfThePapersLoop) {
  const MWidth m_width = ComputeMWidth(PaperLoop());
  EXPECT_NEAR(m_width.lower.mass / 0.07, -1.3981549, 1e-7);
  EXPECT_NEAR(m_width.upper.mass / 0.07, 34.2468304, 1e-7);
  EXPECT_TRUE(ExpectStabilityToEndAt(m_width.lower, PaperLoop(), kAnyTicks));
  EXPECT_TRUE(ExpectStabilityToEndAt(m_width.upper, PaperLoop(), kAnyTicks));
}

TEST(HybridSimulationStability, EndsAtTheEdgesOfThePapersLoopWithDelay) {
  for (const double delay_ticks : {0.5, 1.0, 2.25, 3.0}) {
    LoopParameters loop = PaperLoop();
    loop.delay_s = delay_ticks * loop.period_s;
    const MWidth m_width = ComputeMWidth(loop);
    EXPECT_TRUE(ExpectStabilityToEndAt(m_width.lower, loop, kAnyTicks)) << delay_ticks;
    EXPECT_TRUE(ExpectStabilityToEndAt(m_width.upper, loop, kAnyTicks)) << delay_ticks;
  }
}

TEST(HybridSimulationStability, EndsAtTheEdgesOfAReleasedDevice) {
  // Its velocity decays, its position to anywhere: run, not proven.
  LoopParameters loop = PaperLoop();
  loop.hand_stiffness = 0;
  loop.hand_damping = 0;
  loop.device_damping = 0.5;
  const MWidth m_width = ComputeMWidth(loop);
  for (const Edge& edge : {m_width.lower, m_width.upper}) {
    const uint64_t shown_within = TicksPerOscillation(edge, loop);
    EXPECT_EQ(Watch(loop, kInside * edge.mass, shown_within, 10'000'000), Verdict::kDecays) << edge.mass;
    EXPECT_EQ(Watch(loop, kOutside * edge.mass, shown_within, 10'000'000), Verdict::kGrows) << edge.mass;
  }
}

TEST(HybridSimulationStability, EndsAtTheEdgesOfRandomLoops) {
  std::mt19937_64 random(2012);
  int run_edges = 0;
  for (int i = 0; i < 120; ++i) {
    const LoopParameters loop = RandomLoop(random);
    SCOPED_TRACE(i);
    const MWidth m_width = ComputeMWidth(loop);
    ASSERT_FALSE(m_width.empty());
    for (const Edge& edge : {m_width.lower, m_width.upper}) {
      run_edges += ExpectStabilityToEndAt(edge, loop, 200'000) ? 1 : 0;
    }
  }
  // The other edges are proven only: their loops take longer to show what they do.
  EXPECT_GE(run_edges, 100);
}

}  // namespace
}  // namespace mwidth::model
