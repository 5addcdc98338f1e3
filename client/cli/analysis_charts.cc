#include "client/cli/analysis_charts.h"

#include <limits>
#include <utility>

#include "client/cli/sweep_range.h"

namespace mwidth::cli {
namespace {

plot::Axis ParameterAxis(const v1::SweepRange& range) {
  const auto name = ParameterName(range.parameter());
  return {.label = name,
          .column = name,
          .logarithmic = range.logarithmic(),
          .min = range.min(),
          .max = range.max()};
}

template <typename Column>
plot::Curve CurveOf(const std::string& name, const v1::GetFrequencyResponseResponse& response,
                    const Column& values) {
  return {.name = name,
          .x = {response.frequency_hz().begin(), response.frequency_hz().end()},
          .y = {values.begin(), values.end()}};
}

plot::Axis FrequencyAxis() {
  return {.label = "Frequency, Hz", .column = "frequency_hz", .logarithmic = true};
}

}  // namespace

plot::Chart SweepChart(const std::string& title, const v1::SweepMWidthRequest& request,
                       const v1::SweepMWidthResponse& row, const Units& units) {
  const std::vector<double> x(row.x().begin(), row.x().end());
  const std::string unit = units.mass.text;
  const std::string suffix = units.mass.suffix;
  return {.title = title,
          .x = ParameterAxis(request.x()),
          .panels = {{.title = "Positive mass: stable below the line",
                      .y = {.label = "Largest mass, " + unit, .column = "max_" + suffix, .logarithmic = true},
                      .curves = {{.name = "", .x = x, .y = {row.max().begin(), row.max().end()}}}},
                     {.title = "Negative mass: stable above the line",
                      .y = {.label = "Smallest mass, " + unit, .column = "min_" + suffix},
                      .curves = {{.name = "", .x = x, .y = {row.min().begin(), row.min().end()}}}}},
          .gap = "none"};
}

plot::Map SweepMap(const std::string& title, const v1::SweepMWidthRequest& request,
                   const std::vector<v1::SweepMWidthResponse>& rows, const Units& units) {
  const std::string unit = units.mass.text;
  plot::Map map{.title = title, .x = ParameterAxis(request.x()), .y = ParameterAxis(request.y())};
  map.layers = {{.label = "Largest mass, " + unit, .logarithmic = true}, {.label = "Smallest mass, " + unit}};
  for (const auto& row : rows) {
    map.y_values.push_back(row.y());
    map.x_values.assign(row.x().begin(), row.x().end());
    map.layers[0].rows.emplace_back(row.max().begin(), row.max().end());
    map.layers[1].rows.emplace_back(row.min().begin(), row.min().end());
  }
  return map;
}

plot::Chart BodeChart(const std::string& title, const v1::GetFrequencyResponseResponse& response) {
  plot::Chart chart{.title = title, .x = FrequencyAxis()};
  const auto add = [&](const std::string& label, const std::string& column, const auto& values) {
    if (values.size() > 0) {
      chart.panels.push_back(
          {.y = {.label = label, .column = column}, .curves = {CurveOf("", response, values)}});
    }
  };
  add("Magnitude, dB", "magnitude_db", response.magnitude_db());
  add("Phase, deg", "phase_deg", response.phase_deg());
  add("Effective mass ratio", "effective_mass_ratio", response.effective_mass_ratio());
  add("Effective damping ratio", "effective_damping_ratio", response.effective_damping_ratio());
  return chart;
}

plot::Chart AccuracyChart(const std::string& title, const std::vector<CutoffAccuracy>& accuracies,
                          const CutoffAccuracy& own) {
  constexpr double kGap = std::numeric_limits<double>::quiet_NaN();
  constexpr int kSimulatedColor = 2;
  plot::Curve predicted{.name = "predicted"};
  for (const auto& [cutoff_hz, accuracy] : accuracies) {
    predicted.x.push_back(cutoff_hz);
    predicted.y.push_back(accuracy.has_error() ? accuracy.error() : kGap);
  }
  plot::Panel panel{.y = {.label = "Error of the perceived mass", .column = "error"},
                    .curves = {std::move(predicted)}};
  const auto mark = [&](const std::string& name, double error, int color) {
    panel.curves.push_back(
        {.name = name, .x = {own.cutoff_hz}, .y = {error}, .style = plot::Style::kPoints, .color = color});
  };
  if (own.accuracy.has_error()) {
    mark("this loop", own.accuracy.error(), 1);
  }
  if (own.accuracy.has_simulated_error()) {
    mark("this loop, simulated", own.accuracy.simulated_error(), kSimulatedColor);
  }
  return {.title = title,
          .x = {.label = "Cut-off frequency, Hz", .column = "cutoff_hz", .logarithmic = true},
          .panels = {std::move(panel)},
          .gap = "unstable"};
}

}  // namespace mwidth::cli
