#include "client/cli/figures/bode.h"
#include "client/cli/figures/figures.h"

namespace mwidth::figures {

plot::Chart DampingRatioFigure() {
  constexpr double kHighestRadPerS = 1e4;
  std::vector<BodeLoop> loops;
  for (const double damping_ratio : {0.05, 0.2, 0.5, 1.}) {
    loops.push_back(ContinuousBode("ζ = " + cli::Rounded(damping_ratio), {.damping_ratio = damping_ratio},
                                   kHighestRadPerS));
  }
  return BodeChart("L(s) for several ζ (M/m = 1, ω_n = 100 rad/s, ω_0 = 30 rad/s, 1000 Hz)", loops);
}

}  // namespace mwidth::figures
