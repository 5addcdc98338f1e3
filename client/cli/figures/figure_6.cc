#include <future>

#include "client/cli/figures/figures.h"
#include "client/cli/figures/paper_loops.h"
#include "client/cli/figures/simulated_edge.h"
#include "server/model/continuous_loop.h"
#include "server/model/m_width.h"

namespace mwidth::figures {
namespace {

constexpr double kLowestHz = 1;
constexpr double kHighestHz = 100;

// Upper and lower edge over the cut-off.
struct Boundary {
  plot::Curve upper;
  plot::Curve lower;
};

Boundary Named(const std::string& name, plot::Style style, int color) {
  const plot::Curve curve{.name = name, .style = style, .color = color};
  return {curve, curve};
}

void Append(double cutoff_hz, double lower, double upper, Boundary& boundary) {
  boundary.upper.x.push_back(cutoff_hz);
  boundary.upper.y.push_back(upper);
  boundary.lower.x.push_back(cutoff_hz);
  boundary.lower.y.push_back(lower);
}

// The exact boundary, the continuous one, and simulated points, at one sample rate.
std::vector<Boundary> BoundariesAt(double rate_hz, int color) {
  constexpr int kAnalysedPoints = 120;
  constexpr int kSimulatedPoints = 9;
  auto exact = Named(RateName(rate_hz) + " discrete", plot::Style::kLine, color);
  auto continuous = Named(RateName(rate_hz) + " continuous", plot::Style::kDashes, color);
  auto simulated = Named(RateName(rate_hz) + " simulated", plot::Style::kPoints, color);
  for (const double cutoff_hz : EqualRatios(kLowestHz, kHighestHz, kAnalysedPoints)) {
    const auto loop = TableTwoLoop(rate_hz, cutoff_hz);
    for (auto* boundary : {&exact, &continuous}) {
      const auto edges =
          boundary == &exact ? model::ComputeMWidth(loop) : model::ComputeContinuousMWidth(loop);
      Append(cutoff_hz, edges.lower.mass / loop.device_mass, edges.upper.mass / loop.device_mass, *boundary);
    }
  }
  for (const double cutoff_hz : EqualRatios(kLowestHz, kHighestHz, kSimulatedPoints)) {
    const auto loop = TableTwoLoop(rate_hz, cutoff_hz);
    Append(cutoff_hz, SimulatedEdge(loop, Side::kNegative) / loop.device_mass,
           SimulatedEdge(loop, Side::kPositive) / loop.device_mass, simulated);
  }
  return {exact, continuous, simulated};
}

}  // namespace

plot::Chart StabilityFigure() {
  std::vector<std::future<std::vector<Boundary>>> jobs;
  int color = 0;
  for (const double rate_hz : {500., 1000., 2000., 5000.}) {
    jobs.push_back(std::async(std::launch::async, BoundariesAt, rate_hz, color++));
  }
  plot::Panel upper{.title = "Positive mass: stable below the line",
                    .y = {.label = "Largest M/m", .column = "largest_mass_ratio", .logarithmic = true}};
  plot::Panel lower{.title = "Negative mass: stable above the line",
                    .y = {.label = "Smallest M/m", .column = "smallest_mass_ratio", .min = -4}};
  for (auto& job : jobs) {
    for (auto& boundary : job.get()) {
      upper.curves.push_back(std::move(boundary.upper));
      lower.curves.push_back(std::move(boundary.lower));
    }
  }
  return {.title = "Stable virtual masses (Table II)",
          .x = {.label = "Cut-off frequency f_0, Hz", .column = "cutoff_hz", .logarithmic = true},
          .panels = {std::move(upper), std::move(lower)}};
}

}  // namespace mwidth::figures
