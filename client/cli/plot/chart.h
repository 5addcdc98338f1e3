// What a picture shows, apart from how it is drawn: curves over a common axis, in panels.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace mwidth::plot {

/// One axis of a panel.
struct Axis {
  /// For people, with the unit: "Magnitude, dB".
  std::string label;
  /// The same as a column name: "magnitude_db".
  std::string column;
  bool logarithmic = false;
  /// What is shown; unset: everything.
  std::optional<double> min = std::nullopt;
  std::optional<double> max = std::nullopt;
};

enum class Style { kLine, kDashes, kPoints };

/// Equally many x and y. A y that is not a number is a gap.
struct Curve {
  std::string name;
  std::vector<double> x = {};
  std::vector<double> y = {};
  Style style = Style::kLine;
  /// Curves of one colour belong together; any number from 0.
  int color = 0;
};

struct Panel {
  std::string title = {};
  Axis y;
  std::vector<Curve> curves = {};
};

/// Panels in rows of `columns`, with one legend for each column where they have the same curves.
struct Chart {
  std::string title;
  Axis x;
  std::vector<Panel> panels = {};
  int columns = 1;
  /// What a gap means, as the word that stands for it in the CSV file.
  std::string gap = "NaN";
};

/// Writes the chart's data, one point a line: quantity, curve, the x column, value; numbers with 17
/// significant digits. Throws std::runtime_error where the file cannot be written.
void WriteCsv(const Chart& chart, const std::filesystem::path& file);

/// Draws the chart by gnuplot, as SVG or PNG by the file's extension (".svg" or ".png"). Throws
/// std::runtime_error for another extension, where gnuplot is missing or fails, or the file cannot be
/// written. Ignore SIGPIPE before, or a missing gnuplot ends the program. Blocks.
void Draw(const Chart& chart, const std::filesystem::path& file);

}  // namespace mwidth::plot
