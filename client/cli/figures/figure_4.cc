#include "client/cli/figures/bode.h"
#include "client/cli/figures/figures.h"

namespace mwidth::figures {

plot::Chart SampleRateFigure() {
  constexpr double kHighestRadPerS = 1e4;
  std::vector<BodeLoop> loops;
  for (const double rate_hz : {200., 500., 1000., 5000.}) {
    loops.push_back(ContinuousBode(RateName(rate_hz), {.period_s = 1 / rate_hz}, kHighestRadPerS));
  }
  return BodeChart("L(s) for several sample rates (M/m = 1, ω_n = 100 rad/s, ζ = 0.5, ω_0 = 30 rad/s)",
                   loops);
}

}  // namespace mwidth::figures
