#include "client/cli/figures/simulated_edge.h"

#include <algorithm>
#include <cmath>

#include "server/model/loop_simulation.h"

namespace mwidth::figures {

bool PushDiesOut(const model::LoopParameters& loop, double mass) {
  // A linear loop that has grown a millionfold, or lost all but a billionth, has made up its mind; one that
  // is still in between has to be told from the last two windows, each longer than its slowest swing.
  constexpr double kGrown = 1e6;
  constexpr double kGone = 1e-9;
  constexpr double kWindowS = 1;
  constexpr int kWindows = 20;
  const auto ticks = static_cast<int>(std::ceil(kWindowS / loop.period_s));
  model::LoopSimulation simulation(loop, mass);
  simulation.Reset(0, 1, 0);
  double before = 1;
  double peak = 1;
  for (int window = 0; window < kWindows; ++window) {
    before = peak;
    peak = 0;
    for (int tick = 0; tick < ticks; ++tick) {
      peak = std::max(peak, std::abs(simulation.Step(0).velocity));
      if (!(peak < kGrown)) {
        return false;
      }
    }
    if (peak < kGone) {
      return true;
    }
  }
  return peak < before;
}

double SimulatedEdge(const model::LoopParameters& loop, Side side) {
  constexpr double kStep = 1.1;
  constexpr double kAccuracy = 1e-3;
  const double sign = side == Side::kPositive ? 1 : -1;
  double stable = 0;
  double unstable = loop.device_mass / 10;
  while (PushDiesOut(loop, sign * unstable)) {
    stable = unstable;
    unstable *= kStep;
  }
  while (unstable - stable > kAccuracy * unstable) {
    const double middle = (stable + unstable) / 2;
    (PushDiesOut(loop, sign * middle) ? stable : unstable) = middle;
  }
  return sign * (stable + unstable) / 2;
}

}  // namespace mwidth::figures
