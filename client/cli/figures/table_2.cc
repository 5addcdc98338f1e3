#include "client/cli/figures/figures.h"
#include "client/cli/figures/paper_loops.h"
#include "server/model/continuous_loop.h"
#include "server/model/m_width.h"

namespace mwidth::figures {
namespace {

std::vector<std::string> EdgesRow(const std::string& name, const model::MWidth& edges, double device_mass) {
  return {name, cli::Rounded(edges.lower.mass / device_mass, 4),
          cli::Rounded(edges.upper.mass / device_mass, 4), "times m"};
}

}  // namespace

plot::Table ParameterTable() {
  constexpr double kRateHz = 1000;
  constexpr double kCutoffHz = 10;
  const auto loop = TableTwoLoop(kRateHz, kCutoffHz);
  // H without the z in its numerator is H one tick later.
  auto lagging = loop;
  lagging.delay_s = loop.period_s;
  const auto parameter = [](const std::string& name, double value, const std::string& unit) {
    return std::vector<std::string>{name, cli::Rounded(value), cli::Rounded(value), unit};
  };
  return {.title = "Human and device parameters, and their M-width at 1000 Hz and f_0 = 10 Hz",
          .columns = {"quantity", "min", "max", "unit"},
          .rows = {parameter("k_h", loop.hand_stiffness, "N/m"), parameter("b_h", loop.hand_damping, "N s/m"),
                   parameter("m", loop.device_mass, "kg"), parameter("b", loop.device_damping, "N s/m"),
                   EdgesRow("M, discrete model", model::ComputeMWidth(loop), loop.device_mass),
                   EdgesRow("M, continuous model", model::ComputeContinuousMWidth(loop), loop.device_mass),
                   EdgesRow("M, discrete model without the z in H", model::ComputeMWidth(lagging),
                            loop.device_mass)}};
}

}  // namespace mwidth::figures
