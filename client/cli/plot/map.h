// Values over two parameters, as coloured maps.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "client/cli/plot/chart.h"

namespace mwidth::plot {

/// One map: rows[i][k] is the value at y_values[i], x_values[k]; not a number is a hole.
struct Layer {
  std::string label;
  /// Colours by ratios; all values are then above 0.
  bool logarithmic = false;
  std::vector<std::vector<double>> rows = {};
};

/// Maps over the same grid, side by side; at least two values on each side.
struct Map {
  std::string title;
  Axis x;
  Axis y;
  std::vector<double> x_values = {};
  std::vector<double> y_values = {};
  std::vector<Layer> layers = {};
};

/// As a chart (chart.h). Each cell of the picture has the mean of its four corners.
void Draw(const Map& map, const std::filesystem::path& file);

}  // namespace mwidth::plot
