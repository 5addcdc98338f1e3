#include "client/cli/analysis_tables.h"

#include <cmath>

#include "client/cli/estimator_name.h"
#include "client/cli/numbers.h"
#include "client/cli/sweep_range.h"

namespace mwidth::cli {
namespace {

// "mass_min_kg".
std::string MassColumn(const std::string& name, const Units& units) { return name + "_" + units.mass.suffix; }

// The server answers NaN where there is no edge.
std::string EdgeCell(double edge, Format format) { return std::isnan(edge) ? "none" : format(edge); }

}  // namespace

std::string ForPeople(double value) { return Rounded(value); }

plot::Table MWidthTable(const v1::GetMWidthResponse& response, const Units& units, Format format) {
  plot::Table table{
      .title = "M-width",
      .columns = {"interval", "edge", MassColumn("mass", units), "estimator", "cutoff_hz", "period_s",
                  "device_mass", "device_damping", "hand_mass", "hand_damping", "hand_stiffness", "delay_s"}};
  const auto add = [&](const std::string& name, const char* edge, bool empty, double mass,
                       const v1::LoopParameters& loop) {
    auto& cells = table.rows.emplace_back();
    cells = {name, edge, empty ? "none" : format(mass)};
    if (empty) {
      cells.resize(table.columns.size(), "none");
      return;
    }
    cells.push_back(EstimatorName(loop.estimator()));
    for (const double value :
         {loop.cutoff_hz(), loop.period_s(), loop.device_mass(), loop.device_damping(), loop.hand_mass(),
          loop.hand_damping(), loop.hand_stiffness(), loop.delay_s()}) {
      cells.push_back(format(value));
    }
  };
  const auto add_both = [&](const std::string& name, const v1::Interval& interval,
                            const v1::LoopParameters& min_loop, const v1::LoopParameters& max_loop) {
    add(name, "min", interval.empty(), interval.min(), min_loop);
    add(name, "max", interval.empty(), interval.max(), max_loop);
  };
  const auto& m_width = response.m_width();
  add_both("nominal", m_width.nominal(), response.loop(), response.loop());
  add_both("robust", m_width.robust(), m_width.min_binding(), m_width.max_binding());
  add_both("admitted", m_width.admitted(), m_width.min_binding(), m_width.max_binding());
  return table;
}

plot::Table MarginsTable(const v1::StabilityMargins& margins, Format format) {
  plot::Table table{.title = "Margins", .columns = {"margin", "value", "at_least", "frequency_hz"}};
  const auto add = [&](const std::string& name, double value, double frequency_hz, bool at_least = false) {
    table.rows.push_back({name, format(value), at_least ? "1" : "0", format(frequency_hz)});
  };
  add("gain_db", margins.gain_db(), margins.gain_hz());
  add("phase_deg", margins.phase_deg(), margins.phase_hz());
  add("delay_s", margins.delay_s(), margins.delay_hz(), margins.delay_at_least());
  add("modulus", margins.modulus(), margins.modulus_hz());
  return table;
}

plot::Table SweepTable(const v1::SweepMWidthRequest& request,
                       const std::vector<v1::SweepMWidthResponse>& rows, const Units& units, Format format) {
  plot::Table table{.title = "M-width",
                    .columns = {ParameterName(request.x().parameter()), MassColumn("min", units),
                                MassColumn("max", units)}};
  if (request.has_y()) {
    table.columns.insert(table.columns.begin(), ParameterName(request.y().parameter()));
  }
  for (const auto& row : rows) {
    for (int i = 0; i < row.x_size(); ++i) {
      auto& cells = table.rows.emplace_back();
      if (request.has_y()) {
        cells.push_back(format(row.y()));
      }
      cells.push_back(format(row.x(i)));
      cells.push_back(EdgeCell(row.min(i), format));
      cells.push_back(EdgeCell(row.max(i), format));
    }
  }
  return table;
}

plot::Table BodeTable(const v1::GetFrequencyResponseResponse& response, Format format) {
  plot::Table table{.title = "Frequency response", .columns = {"frequency_hz", "magnitude_db", "phase_deg"}};
  const bool mass = response.effective_mass_ratio_size() > 0;
  const bool damping = response.effective_damping_ratio_size() > 0;
  if (mass) {
    table.columns.emplace_back("effective_mass_ratio");
  }
  if (damping) {
    table.columns.emplace_back("effective_damping_ratio");
  }
  for (int i = 0; i < response.frequency_hz_size(); ++i) {
    auto& cells = table.rows.emplace_back();
    cells = {format(response.frequency_hz(i)), format(response.magnitude_db(i)),
             format(response.phase_deg(i))};
    if (mass) {
      cells.push_back(format(response.effective_mass_ratio(i)));
    }
    if (damping) {
      cells.push_back(format(response.effective_damping_ratio(i)));
    }
  }
  return table;
}

plot::Table AccuracyTable(const v1::Accuracy& accuracy, const Units& units, Format format) {
  plot::Table table{.title = "Accuracy", .columns = {"quantity", "value"}};
  const auto add = [&](const std::string& name, bool known, double value) {
    if (known) {
      table.rows.push_back({name, format(value)});
    }
  };
  add(MassColumn("ideal_mass", units), true, accuracy.ideal_mass());
  add(MassColumn("perceived_mass", units), accuracy.has_perceived_mass(), accuracy.perceived_mass());
  add("error", accuracy.has_error(), accuracy.error());
  add(MassColumn("simulated_perceived_mass", units), accuracy.has_simulated_perceived_mass(),
      accuracy.simulated_perceived_mass());
  add("simulated_error", accuracy.has_simulated_error(), accuracy.simulated_error());
  add(std::string("force_noise_") + units.force.suffix, accuracy.has_force_noise(), accuracy.force_noise());
  return table;
}

}  // namespace mwidth::cli
