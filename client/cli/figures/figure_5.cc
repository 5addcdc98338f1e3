#include "client/cli/figures/bode.h"
#include "client/cli/figures/figures.h"

namespace mwidth::figures {

plot::Chart NaturalFrequencyFigure() {
  constexpr double kHighestRadPerS = 1e4;
  std::vector<BodeLoop> loops;
  for (const double rad_per_s : {20., 50., 100., 300.}) {
    loops.push_back(ContinuousBode("ω_n = " + cli::Rounded(rad_per_s) + " rad/s",
                                   {.natural_rad_per_s = rad_per_s}, kHighestRadPerS));
  }
  return BodeChart("L(s) for several ω_n (M/m = 1, ζ = 0.5, ω_0 = 30 rad/s, 1000 Hz)", loops);
}

}  // namespace mwidth::figures
