#include <numbers>

#include "client/cli/figures/bode.h"
#include "client/cli/figures/figures.h"
#include "server/model/frequency_response.h"

namespace mwidth::figures {

plot::Chart ModelComparisonFigure() {
  const RatioLoop ratios;
  const auto loop = ratios.Loop();
  const double mass = ratios.Mass();
  const double nyquist_rad_per_s = std::numbers::pi / ratios.period_s;
  const model::SampledResponse sampled(loop);
  const BodeLoop discrete{.name = "discrete, L(z)",
                          .gain = [&](double hz) { return sampled.Loop(mass, hz); },
                          .mass = mass,
                          .edges = model::ComputeMWidth(loop),
                          .highest_rad_per_s = nyquist_rad_per_s};
  return BodeChart(
      "Continuous and discrete model (M/m = 1, ω_n = 100 rad/s, ζ = 0.5, ω_0 = 30 rad/s, 1000 Hz)",
      {ContinuousBode("continuous, L(s)", ratios, nyquist_rad_per_s), discrete});
}

}  // namespace mwidth::figures
