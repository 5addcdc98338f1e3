#include <limits>

#include "client/cli/figures/figures.h"
#include "client/cli/figures/paper_loops.h"
#include "server/model/accuracy.h"

namespace mwidth::figures {
namespace {

constexpr double kRateHz = 1000;

// The error where there is one; a gap where the pair is unstable.
double ErrorOf(const model::PerceivedMass& perceived) {
  return perceived.error.value_or(std::numeric_limits<double>::quiet_NaN());
}

// Cut-offs that include 10 Hz, the paper's example.
std::vector<double> Cutoffs(int count) {
  constexpr double kLowestHz = 2;
  constexpr double kHighestHz = 50;
  return EqualRatios(kLowestHz, kHighestHz, count);
}

plot::Panel ErrorPanel(const std::string& title, const std::vector<double>& mass_ratios) {
  constexpr int kPredictedPoints = 61;
  constexpr int kSimulatedPoints = 13;
  const model::MotionBand band;
  plot::Panel panel{.title = title, .y = {.label = "Error of the perceived mass", .column = "error"}};
  int color = 0;
  for (const double ratio : mass_ratios) {
    plot::Curve predicted{
        .name = MassName(ratio) + " predicted", .x = Cutoffs(kPredictedPoints), .color = color};
    plot::Curve simulated{.name = MassName(ratio) + " simulated",
                          .x = Cutoffs(kSimulatedPoints),
                          .style = plot::Style::kPoints,
                          .color = color};
    for (const double cutoff_hz : predicted.x) {
      const auto loop = TableTwoLoop(kRateHz, cutoff_hz);
      predicted.y.push_back(ErrorOf(model::PredictPerceivedMass(loop, ratio * loop.device_mass, band)));
    }
    for (const double cutoff_hz : simulated.x) {
      const auto loop = TableTwoLoop(kRateHz, cutoff_hz);
      simulated.y.push_back(ErrorOf(model::MeasurePerceivedMass(loop, ratio * loop.device_mass, band)));
    }
    panel.curves.push_back(std::move(predicted));
    panel.curves.push_back(std::move(simulated));
    ++color;
  }
  return panel;
}

}  // namespace

plot::Chart PerceivedMassFigure() {
  return {.title = "Error of the perceived mass (Table II, 1000 Hz, chirp of 0.1 to 5 Hz in 60 s)",
          .x = {.label = "Cut-off frequency f_0, Hz", .column = "cutoff_hz", .logarithmic = true},
          .panels = {ErrorPanel("Positive mass", {0.5, 1, 3, 10}),
                     ErrorPanel("Negative mass", {-0.25, -0.5, -0.75, -0.9})},
          .gap = "unstable"};
}

}  // namespace mwidth::figures
