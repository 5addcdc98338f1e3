#include "client/cli/figures/bode.h"

#include <cmath>
#include <numbers>

#include "server/model/continuous_loop.h"

namespace mwidth::figures {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kLowestRadPerS = 1;
constexpr int kPoints = 300;

double Decibels(double factor) { return 20 * std::log10(factor); }
double Degrees(double radians) { return radians * 180 / std::numbers::pi; }

struct BodeCurves {
  plot::Curve magnitude;
  plot::Curve phase;
};

BodeCurves CurvesOf(const BodeLoop& loop, int color) {
  BodeCurves curves;
  curves.magnitude = {.name = loop.name, .color = color};
  curves.phase = curves.magnitude;
  double phase = 0;
  std::complex<double> previous = 1;
  for (const double rad_per_s : EqualRatios(kLowestRadPerS, loop.highest_rad_per_s, kPoints)) {
    const auto gain = loop.gain(rad_per_s / kTwoPi);
    // From point to point the phase changes by far less than half a turn.
    phase += Degrees(std::arg(gain / previous));
    previous = gain;
    curves.magnitude.x.push_back(rad_per_s);
    curves.magnitude.y.push_back(Decibels(std::abs(gain)));
    curves.phase.x.push_back(rad_per_s);
    curves.phase.y.push_back(phase);
  }
  return curves;
}

// At w* the gain margin in decibels is minus the magnitude (eq. 15).
void AppendMark(const BodeLoop& loop, const model::Edge& edge, double phase_deg, BodeCurves& marks) {
  marks.magnitude.x.push_back(kTwoPi * edge.critical_hz);
  marks.magnitude.y.push_back(-Decibels(std::abs(edge.mass / loop.mass)));
  marks.phase.x.push_back(kTwoPi * edge.critical_hz);
  marks.phase.y.push_back(phase_deg);
}

BodeCurves MarksNamed(const std::string& name, int color) {
  const plot::Curve marks{.name = name, .style = plot::Style::kPoints, .color = color};
  return {marks, marks};
}

}  // namespace

BodeLoop ContinuousBode(const std::string& name, const RatioLoop& ratios, double highest_rad_per_s) {
  const auto loop = ratios.Loop();
  const double mass = ratios.Mass();
  return {.name = name,
          .gain = [loop, mass](double hz) { return model::ContinuousLoop(loop, mass, hz); },
          .mass = mass,
          .edges = model::ComputeContinuousMWidth(loop),
          .highest_rad_per_s = highest_rad_per_s};
}

plot::Chart BodeChart(const std::string& title, const std::vector<BodeLoop>& loops) {
  plot::Panel magnitude{.y = {.label = "Magnitude, dB", .column = "magnitude_db"}};
  plot::Panel phase{.title = "", .y = {.label = "Phase, deg", .column = "phase_deg", .min = -360}};
  constexpr int kPositiveColor = 6;
  constexpr int kNegativeColor = 5;
  auto positive = MarksNamed("ω* for M > 0", kPositiveColor);
  auto negative = MarksNamed("ω* for M < 0", kNegativeColor);
  int color = 0;
  for (const auto& loop : loops) {
    auto curves = CurvesOf(loop, color++);
    magnitude.curves.push_back(std::move(curves.magnitude));
    phase.curves.push_back(std::move(curves.phase));
    AppendMark(loop, loop.edges.upper, -180, positive);
    AppendMark(loop, loop.edges.lower, 0, negative);
  }
  for (auto* marks : {&positive, &negative}) {
    magnitude.curves.push_back(std::move(marks->magnitude));
    phase.curves.push_back(std::move(marks->phase));
  }
  return {.title = title,
          .x = {.label = "Frequency, rad/s", .column = "frequency_rad_per_s", .logarithmic = true},
          .panels = {std::move(magnitude), std::move(phase)}};
}

}  // namespace mwidth::figures
