#include "tests/bench/rendering_loops.h"

#include <cmath>
#include <cstddef>
#include <random>

namespace mwidth::bench {

model::LoopParameters PaperLoop(double delay_ticks) {
  return {.device_mass = 0.07,
          .device_damping = 0.005,
          .hand_damping = 5,
          .hand_stiffness = 700,
          .period_s = 1e-3,
          .cutoff_hz = 10,
          .delay_s = delay_ticks * 1e-3};
}

std::vector<model::LoopParameters> BoxLoops(int count) {
  std::mt19937_64 random(2012);
  const auto log_uniform = [&](double low, double high) {
    return std::exp(std::uniform_real_distribution<double>(std::log(low), std::log(high))(random));
  };
  std::vector<model::LoopParameters> loops(static_cast<std::size_t>(count));
  for (model::LoopParameters& loop : loops) {
    loop.device_mass = log_uniform(1e-3, 1e2);
    loop.device_damping = log_uniform(1e-4, 1e1);
    loop.hand_damping = log_uniform(1e-2, 3e2);
    loop.hand_stiffness = log_uniform(1, 3e4);
    loop.period_s = log_uniform(1e-5, 1e-2);
    loop.cutoff_hz = log_uniform(1e-3, 0.48) / loop.period_s;
  }
  return loops;
}

}  // namespace mwidth::bench
