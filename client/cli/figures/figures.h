// The paper's figures and tables, computed anew.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "client/cli/plot/chart.h"
#include "client/cli/plot/table.h"

namespace mwidth::figures {

/// Loop gain for several sample rates.
plot::Chart SampleRateFigure();  // Figure 4
/// Loop gain for several natural frequencies of the held device.
plot::Chart NaturalFrequencyFigure();  // Figure 5
/// Stable masses over the filter's cut-off for several sample rates: exact, continuous, simulated.
plot::Chart StabilityFigure();  // Figure 6
/// Loop gain of the continuous and of the discrete model.
plot::Chart ModelComparisonFigure();  // Figure 7
/// What the hand feels over frequency, with a positive and a negative mass.
plot::Chart RenderedMassFigure();  // Figure 8
/// Error of the perceived mass over the filter's cut-off: predicted, simulated.
plot::Chart PerceivedMassFigure();  // Figure 9
/// Loop gain for several damping ratios of the held device.
plot::Chart DampingRatioFigure();  // Figure 10
/// How each parameter moves the gain margin.
plot::Table GainMarginTable();  // Table I
/// Human and device parameters, and the M-width that they have.
plot::Table ParameterTable();  // Table II

struct Figure {
  /// Name of its files without the extension: "figure-4".
  std::string name;
  std::function<std::variant<plot::Chart, plot::Table>()> compute;
};

/// All of them, in the paper's order.
const std::vector<Figure>& AllFigures();

/// Called before each figure.
using Progress = std::function<void(size_t number, size_t count, const std::string& name)>;

/// Computes all figures and writes each into `folder`, which is made where it does not exist: the picture as
/// NAME`extension` (".svg" or ".png") and its data as NAME.csv. Throws std::runtime_error where a file cannot
/// be written or gnuplot is missing. Takes some seconds.
void WriteAllFigures(const std::filesystem::path& folder, const std::string& extension,
                     const Progress& progress);

}  // namespace mwidth::figures
