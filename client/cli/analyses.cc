// m-width, sweep, bode and accuracy: ask, then show.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <iostream>
#include <vector>

#include "client/cli/analysis_charts.h"
#include "client/cli/analysis_tables.h"
#include "client/cli/commands.h"
#include "client/cli/connection.h"
#include "client/cli/json.h"
#include "client/cli/loop_words.h"
#include "client/cli/numbers.h"
#include "client/cli/report.h"

namespace mwidth::cli {
namespace {

void TellWritten(const std::string& file) { std::cerr << "wrote " << file << "\n"; }

// `table` makes the table in the given format.
template <typename MakeTable>
void WriteTable(const CommandLine& line, const MakeTable& table) {
  if (line.csv) {
    plot::WriteCsv(table(Exact), *line.csv);
    TellWritten(*line.csv);
  }
}

template <typename Picture>
void DrawPicture(const CommandLine& line, const Picture& picture) {
  plot::Draw(picture, *line.plot);
  TellWritten(*line.plot);
}

// A long table goes to the terminal only where it goes nowhere else.
bool ToTerminal(const CommandLine& line) { return !line.json && !line.csv && !line.plot; }

std::vector<v1::SweepMWidthResponse> Collect(const client::Client& client,
                                             const v1::SweepMWidthRequest& request,
                                             const std::function<void(const v1::SweepMWidthResponse&)>& see) {
  std::vector<v1::SweepMWidthResponse> rows;
  client.SweepMWidth(request, [&](const v1::SweepMWidthResponse& row) {
    see(row);
    rows.push_back(row);
    return true;
  });
  return rows;
}

// Cut-offs around the loop's own, as a range of a sweep.
v1::SweepRange CutoffsAround(const v1::LoopParameters& loop) {
  constexpr double kDecade = 10;
  constexpr uint32_t kCount = 101;
  v1::SweepRange range;
  range.set_parameter(v1::SWEEP_PARAMETER_CUTOFF_HZ);
  range.set_min(loop.cutoff_hz() / kDecade);
  range.set_max(std::min(loop.cutoff_hz() * kDecade, 0.5 / loop.period_s()));
  range.set_count(kCount);
  range.set_logarithmic(true);
  return range;
}

void DrawMWidth(const CommandLine& line, const client::Client& client, const v1::LoopParameters& loop,
                const v1::AxisInfo& axis) {
  v1::SweepMWidthRequest request;
  request.set_axis(line.axis);
  *request.mutable_loop() = line.overrides;
  *request.mutable_x() = CutoffsAround(loop);
  const auto rows = Collect(client, request, [](const auto&) {});
  DrawPicture(line, SweepChart(axis.name() + ": nominally stable virtual masses", request, rows.at(0),
                               UnitsOf(axis.kind())));
}

// Asks again for every cut-off, without simulating.
void DrawAccuracy(const CommandLine& line, const client::Client& client, v1::GetAccuracyRequest request,
                  const v1::GetAccuracyResponse& own, const v1::AxisInfo& axis) {
  request.set_simulate(false);
  const auto range = CutoffsAround(own.loop());
  std::vector<CutoffAccuracy> accuracies;
  for (uint32_t i = 0; i < range.count(); ++i) {
    const double part = static_cast<double>(i) / (range.count() - 1);
    const double cutoff_hz = std::min(range.min() * std::pow(range.max() / range.min(), part), range.max());
    request.mutable_loop()->set_cutoff_hz(cutoff_hz);
    accuracies.push_back({cutoff_hz, client.Accuracy(request).accuracy()});
  }
  const auto title = axis.name() + ": rendering " + Rounded(line.mass) + " " + UnitsOf(axis.kind()).mass.text;
  DrawPicture(line, AccuracyChart(title, accuracies, {own.loop().cutoff_hz(), own.accuracy()}));
}

// The server's rule of what an override leaves of the axis's own assumptions.
Assumptions Assumed(const CommandLine& line, const v1::AxisInfo& axis) {
  const bool own = line.overrides.ByteSizeLong() == 0 && !line.envelope && !line.tolerance;
  return own ? AssumptionsOf(axis) : Assumptions{line.envelope, line.tolerance};
}

// What was analysed, above its figures.
void TellLoop(const v1::AxisInfo& axis, const v1::LoopParameters& loop) {
  std::cout << axis.name() << ": " << LoopText(loop, UnitsOf(axis.kind())) << "\n\n";
}

// Into "bode-margins.csv" beside "bode.csv".
void WriteMargins(const CommandLine& line, const v1::StabilityMargins& margins) {
  if (line.csv) {
    const std::filesystem::path file(*line.csv);
    auto name = file.stem();
    name += "-margins";
    name += file.extension();
    const auto beside = (file.parent_path() / name).string();
    plot::WriteCsv(MarginsTable(margins, Exact), beside);
    TellWritten(beside);
  }
}

}  // namespace

int RunMWidth(const CommandLine& line) {
  const auto connection = Open(line);
  const auto response = connection.client.MWidth(line.axis, line.overrides, line.envelope, line.tolerance);
  const auto axis = connection.client.Axis(line.axis).info();
  std::cout << (line.json ? ToJson(response) : MWidthReport(response, axis, Assumed(line, axis)));
  WriteTable(line, [&](Format format) { return MWidthTable(response, UnitsOf(axis.kind()), format); });
  if (line.plot) {
    DrawMWidth(line, connection.client, response.loop(), axis);
  }
  return kDone;
}

int RunSweep(const CommandLine& line) {
  const auto connection = Open(line);
  const auto axis = connection.client.Axis(line.axis).info();
  const auto& units = UnitsOf(axis.kind());
  auto request = line.sweep;
  request.set_axis(line.axis);
  *request.mutable_loop() = line.overrides;
  const bool progress = isatty(STDERR_FILENO) != 0 && request.has_y();
  const auto rows = Collect(connection.client, request, [&](const v1::SweepMWidthResponse& row) {
    if (line.json) {
      std::cout << ToJson(row, /*one_line=*/true);
    }
    if (progress) {
      std::cerr << "\r" << row.row() + 1 << "/" << row.row_count()
                << (row.row() + 1 == row.row_count() ? "\n" : "");
    }
  });
  const auto table = [&](Format format) { return SweepTable(request, rows, units, format); };
  if (ToTerminal(line)) {
    std::cout << plot::ToText(table(ForPeople));
  }
  WriteTable(line, table);
  if (line.plot && request.has_y()) {
    DrawPicture(line, SweepMap(axis.name() + ": stable virtual masses", request, rows, units));
  } else if (line.plot) {
    DrawPicture(line, SweepChart(axis.name() + ": stable virtual masses", request, rows.at(0), units));
  }
  return kDone;
}

int RunBode(const CommandLine& line) {
  constexpr uint32_t kTerminalCount = 25;
  const auto connection = Open(line);
  auto request = line.bode;
  request.set_axis(line.axis);
  request.set_mass(line.mass);
  *request.mutable_loop() = line.overrides;
  if (request.count() == 0 && ToTerminal(line)) {
    request.set_count(kTerminalCount);
  }
  const auto response = connection.client.FrequencyResponse(request);
  const auto axis = connection.client.Axis(line.axis).info();
  const auto table = [&](Format format) { return BodeTable(response, format); };
  if (line.json) {
    std::cout << ToJson(response);
  } else {
    TellLoop(axis, response.loop());
    if (ToTerminal(line)) {
      std::cout << plot::ToText(table(ForPeople)) << "\n";
    }
    if (response.has_margins()) {
      std::cout << "Margins: " << MarginsText(response.margins()) << ".\n";
    }
  }
  if (!response.effective_missing_reason().empty()) {
    std::cerr << "No effective ratios: " << response.effective_missing_reason() << "\n";
  }
  WriteTable(line, table);
  if (response.has_margins()) {
    WriteMargins(line, response.margins());
  }
  if (line.plot) {
    DrawPicture(line, BodeChart(axis.name() + ": loop with a virtual mass of " + Rounded(line.mass) + " " +
                                    UnitsOf(axis.kind()).mass.text,
                                response));
  }
  return kDone;
}

int RunAccuracy(const CommandLine& line) {
  const auto connection = Open(line);
  auto request = line.accuracy;
  request.set_axis(line.axis);
  request.set_mass(line.mass);
  *request.mutable_loop() = line.overrides;
  const auto response = connection.client.Accuracy(request);
  const auto& accuracy = response.accuracy();
  const auto axis = connection.client.Axis(line.axis).info();
  const auto table = [&](Format format) { return AccuracyTable(accuracy, UnitsOf(axis.kind()), format); };
  if (line.json) {
    std::cout << ToJson(response);
  } else {
    TellLoop(axis, response.loop());
    std::cout << plot::ToText(table(ForPeople));
  }
  if (!accuracy.unavailable_reason().empty()) {
    std::cerr << accuracy.unavailable_reason() << "\n";
  }
  WriteTable(line, table);
  if (line.plot) {
    DrawAccuracy(line, connection.client, request, response, axis);
  }
  return kDone;
}

}  // namespace mwidth::cli
