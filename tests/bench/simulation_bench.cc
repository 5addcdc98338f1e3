// One tick of the exact simulation, recording off, against the same loop as bare recurrences.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "server/model/loop_simulation.h"
#include "server/model/plant_response.h"
#include "tests/bench/rendering_loops.h"

namespace mwidth::bench {
namespace {

using model::Imperfections;
using model::LoopParameters;
using model::LoopSimulation;

constexpr double kMass = 0.07;
// Times below are per run of this many ticks.
constexpr std::size_t kTicks = 1000;

/// A hand that goes to and fro at 2 Hz, at the beginning of each tick and at the end of the last.
std::vector<double> HandMotion() {
  std::vector<double> hand(kTicks + 1);
  for (std::size_t tick = 0; tick < hand.size(); ++tick) {
    hand[tick] = 0.02 * std::sin(2 * std::numbers::pi * 2e-3 * static_cast<double>(tick));
  }
  return hand;
}

double FinalPosition(LoopSimulation& simulation, const std::vector<double>& hand) {
  simulation.Reset(0, 0, 0);
  for (std::size_t tick = 0; tick < kTicks; ++tick) {
    simulation.Step(hand[tick + 1]);
  }
  return simulation.Step(0).position;
}

void Simulate(benchmark::State& state, const LoopParameters& loop, const Imperfections& imperfections) {
  const std::vector<double> hand = HandMotion();
  LoopSimulation simulation(loop, kMass, imperfections);
  double position = 0;
  for (auto _ : state) {
    position = FinalPosition(simulation, hand);
    benchmark::DoNotOptimize(position);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(kTicks));
  state.counters["position"] = position;
}
BENCHMARK_CAPTURE(Simulate, exact, PaperLoop(), Imperfections{});
BENCHMARK_CAPTURE(Simulate, exact_delayed, PaperLoop(1.5), Imperfections{});
BENCHMARK_CAPTURE(Simulate, counts, PaperLoop(), {.position_quantum = 1e-5, .force_quantum = 1e-3});
BENCHMARK_CAPTURE(Simulate, friction, PaperLoop(), {.coulomb_friction = 0.2});

/// Device and hand as x(k+1) = trace x(k) - determinant x(k-1) + hand and force of two ticks (eq. 10).
struct PlantRecurrence {
  explicit PlantRecurrence(const LoopParameters& loop);

  double trace = 0;
  double determinant = 0;
  double hand_next = 0;
  double hand_now = 0;
  double hand_before = 0;
  double force_now = 0;
  double force_before = 0;
};

PlantRecurrence::PlantRecurrence(const LoopParameters& loop) {
  const double k = loop.hand_stiffness / loop.device_mass;
  const double b_h = loop.hand_damping / loop.device_mass;
  const double period = loop.period_s;
  const model::PlantResponse at =
      model::RespondAfter(period, (loop.device_damping + loop.hand_damping) / loop.device_mass, k);
  const double kept = 1 - at.velocity_loss;
  trace = 1 - k * at.step + kept;
  determinant = (1 - k * at.step) * kept + k * at.impulse * at.impulse;
  // What an input that adds `x` and `v` in its tick adds to the position one tick later.
  const auto later = [&](double x, double v) { return at.impulse * v - kept * x; };
  const double step_x = (b_h * at.step + k * at.ramp) / period;
  const double step_v = (b_h * at.impulse + k * at.step) / period;
  hand_next = step_x;
  hand_now = k * at.step - step_x + later(step_x, step_v);
  hand_before = later(k * at.step - step_x, k * at.impulse - step_v);
  force_now = -at.step / loop.device_mass;
  force_before = later(-at.step, -at.impulse) / loop.device_mass;
}

/// Eqs. 3 to 5 and 10 as scalars in registers: divisions by T made multiplications, no object, no sample.
void BareRecurrence(benchmark::State& state) {
  const LoopParameters loop = PaperLoop();
  const std::vector<double> hand = HandMotion();
  const PlantRecurrence plant(loop);
  const double rate_hz = 1 / loop.period_s;
  const double pole = std::exp(-2 * std::numbers::pi * loop.cutoff_hz * loop.period_s);
  double mass = kMass;
  double x = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(mass);
    x = 0;
    double x_before = 0;
    double v_before = 0;
    double a = 0;
    double force_before = 0;
    double hand_before = 0;
    for (std::size_t tick = 0; tick < kTicks; ++tick) {
      const double v = (x - x_before) * rate_hz;
      a = pole * a + (1 - pole) * ((v - v_before) * rate_hz);
      const double force = mass * a;
      const double next = plant.trace * x - plant.determinant * x_before + plant.hand_next * hand[tick + 1] +
                          plant.hand_now * hand[tick] + plant.hand_before * hand_before +
                          plant.force_before * force_before + plant.force_now * force;
      x_before = x;
      v_before = v;
      force_before = force;
      hand_before = hand[tick];
      x = next;
    }
    benchmark::DoNotOptimize(x);
  }
  LoopSimulation simulation(loop, kMass);
  if (std::abs(x - FinalPosition(simulation, hand)) > 1e-9 * std::abs(x)) {
    state.SkipWithError("the recurrence and the simulation are not of the same loop");
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(kTicks));
}
BENCHMARK(BareRecurrence);

}  // namespace
}  // namespace mwidth::bench
