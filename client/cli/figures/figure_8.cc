#include <cmath>
#include <complex>
#include <functional>
#include <numbers>

#include "client/cli/figures/figures.h"
#include "client/cli/figures/paper_loops.h"
#include "server/model/frequency_response.h"

namespace mwidth::figures {
namespace {

constexpr double kRateHz = 1000;
constexpr double kCutoffHz = 10;
constexpr double kLowestHz = 0.1;
constexpr double kHighestHz = 100;
constexpr int kPoints = 300;

// Force of the hand over its motion, F_h/X_h at a frequency in Hz: the ideal, the device alone, the
// rendering.
struct System {
  std::string name;
  std::function<std::complex<double>(double)> stiffness;
};

// The four quantities of one system, in the order of the panels.
std::vector<plot::Curve> CurvesOf(const System& system, const std::string& mass_name, int color) {
  constexpr int kQuantities = 4;
  const auto loop = TableTwoLoop(kRateHz, kCutoffHz);
  const plot::Curve empty{.name = mass_name + ", " + system.name, .color = color};
  std::vector<plot::Curve> curves(kQuantities, empty);
  double phase = 0;
  std::complex<double> previous = 1;
  for (const double hz : EqualRatios(kLowestHz, kHighestHz, kPoints)) {
    const auto stiffness = system.stiffness(hz);
    phase += std::arg(stiffness / previous) * 180 / std::numbers::pi;
    previous = stiffness;
    const auto ratios = model::ComputeEffectiveRatios(loop, stiffness, hz);
    const std::vector<double> values = {20 * std::log10(std::abs(stiffness)), phase, ratios.mass,
                                        ratios.damping.value()};
    for (size_t i = 0; i < values.size(); ++i) {
      curves[i].x.push_back(hz);
      curves[i].y.push_back(values[i]);
    }
  }
  return curves;
}

std::vector<System> SystemsWith(double mass) {
  const auto loop = TableTwoLoop(kRateHz, kCutoffHz);
  return {{"ideal", [=](double hz) { return model::IdealStiffness(loop, mass, hz); }},
          {"device", [=](double hz) { return model::RenderedStiffness(loop, 0, hz); }},
          {"rendered", [=](double hz) { return model::RenderedStiffness(loop, mass, hz); }}};
}

}  // namespace

plot::Chart RenderedMassFigure() {
  constexpr double kPositiveRatio = 3;
  constexpr double kNegativeRatio = -0.5;
  const std::vector<plot::Axis> quantities = {
      {.label = "Magnitude, dB", .column = "magnitude_db"},
      {.label = "Phase, deg", .column = "phase_deg"},
      {.label = "Effective mass ratio", .column = "effective_mass_ratio", .min = -1, .max = 5},
      {.label = "Effective damping ratio", .column = "effective_damping_ratio", .min = -1, .max = 4}};
  plot::Chart chart{.title = "Force over motion of the hand (Table II, 1000 Hz, f_0 = 10 Hz)",
                    .x = {.label = "Frequency, Hz", .column = "frequency_hz", .logarithmic = true},
                    .columns = 2};
  for (const auto& quantity : quantities) {
    for (int column = 0; column < chart.columns; ++column) {
      chart.panels.push_back({.y = quantity});
    }
  }
  int column = 0;
  for (const double ratio : {kPositiveRatio, kNegativeRatio}) {
    int color = 0;
    for (const auto& system : SystemsWith(ratio * TableTwoLoop(kRateHz, kCutoffHz).device_mass)) {
      auto curves = CurvesOf(system, MassName(ratio), color++);
      for (size_t row = 0; row < curves.size(); ++row) {
        chart.panels[2 * row + static_cast<size_t>(column)].curves.push_back(std::move(curves[row]));
      }
    }
    ++column;
  }
  return chart;
}

}  // namespace mwidth::figures
