#include <algorithm>
#include <array>
#include <sstream>

#include "client/cli/numbers.h"
#include "client/cli/plot/chart.h"
#include "client/cli/plot/gnuplot.h"

namespace mwidth::plot {
namespace {

// Okabe and Ito's colours, told apart also by the colour-blind.
constexpr std::array kColors = {"#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"};
constexpr int kDigits = 8;

std::string Range(const Axis& axis) {
  const auto end = [](std::optional<double> value) { return value ? cli::Rounded(*value, kDigits) : "*"; };
  return "[" + end(axis.min) + ":" + end(axis.max) + "]";
}

std::string StyleOf(const Curve& curve) {
  const std::string color = kColors.at(static_cast<size_t>(curve.color) % kColors.size());
  switch (curve.style) {
    case Style::kPoints:
      return "with points pointtype 7 pointsize 0.5 linecolor rgb '" + color + "'";
    case Style::kDashes:
      return "with lines linewidth 1.5 dashtype 2 linecolor rgb '" + color + "'";
    case Style::kLine:
      break;
  }
  return "with lines linewidth 1.5 linecolor rgb '" + color + "'";
}

void AppendAxis(const std::string& name, const Axis& axis, std::ostream& out) {
  // The range last: gnuplot refuses a negative end that the panel before would have it take the logarithm of.
  out << "set autoscale " << name << "\n"
      << (axis.logarithmic ? "set" : "unset") << " logscale " << name << "\n"
      << "set " << name << "range " << Range(axis) << "\n";
}

void AppendPanel(const Panel& panel, size_t number, std::ostream& out) {
  for (size_t i = 0; i < panel.curves.size(); ++i) {
    const auto& curve = panel.curves[i];
    out << "$data_" << number << "_" << i << " << END\n";
    for (size_t k = 0; k < curve.x.size(); ++k) {
      out << cli::Rounded(curve.x[k], kDigits) << " " << cli::Rounded(curve.y[k], kDigits) << "\n";
    }
    out << "END\n";
  }
  out << "set title " << GnuplotString(panel.title) << "\nset ylabel " << GnuplotString(panel.y.label)
      << "\n";
  AppendAxis("y", panel.y, out);
  out << "plot ";
  for (size_t i = 0; i < panel.curves.size(); ++i) {
    out << (i == 0 ? "" : ", ") << "$data_" << number << "_" << i << " " << StyleOf(panel.curves[i])
        << " title " << GnuplotString(panel.curves[i].name);
  }
  out << "\n";
}

// A panel below another with the same curves needs no legend of its own.
bool Repeats(const Panel& panel, const Panel& above) {
  return std::equal(panel.curves.begin(), panel.curves.end(), above.curves.begin(), above.curves.end(),
                    [](const Curve& a, const Curve& b) { return a.name == b.name; });
}

// Room at the right for the longest name of a curve.
size_t LegendWidth(const Chart& chart) {
  size_t longest = 0;
  for (const auto& panel : chart.panels) {
    for (const auto& curve : panel.curves) {
      longest = std::max(longest, curve.name.size());
    }
  }
  return longest;
}

}  // namespace

void Draw(const Chart& chart, const std::filesystem::path& file) {
  constexpr int kPanelWidth = 500;
  constexpr int kPanelHeight = 260;
  constexpr int kCharacterWidth = 8;
  const auto columns = static_cast<size_t>(chart.columns);
  const auto rows = (chart.panels.size() + columns - 1) / columns;
  const auto legend_width = LegendWidth(chart);
  std::ostringstream script;
  script << "set multiplot layout " << rows << "," << columns << " title " << GnuplotString(chart.title)
         << "\n"
         << "set grid\nset lmargin 10\nset rmargin " << legend_width + 7 << "\n"
         << "set key outside right top Left reverse\n";
  AppendAxis("x", chart.x, script);
  for (size_t i = 0; i < chart.panels.size(); ++i) {
    const bool lowest = i + columns >= chart.panels.size();
    const bool repeats = i >= columns && Repeats(chart.panels[i], chart.panels[i - columns]);
    script << "set xlabel " << GnuplotString(lowest ? chart.x.label : "") << "\n"
           << (repeats ? "unset key\n" : "set key\n");
    AppendPanel(chart.panels[i], i, script);
  }
  script << "unset multiplot\n";
  const auto width = chart.columns * (kPanelWidth + kCharacterWidth * static_cast<int>(legend_width));
  RunGnuplot(script.str(), file, width, 40 + static_cast<int>(rows) * kPanelHeight);
}

}  // namespace mwidth::plot
