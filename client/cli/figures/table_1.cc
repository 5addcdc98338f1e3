#include <cmath>
#include <functional>
#include <numbers>

#include "client/cli/figures/figures.h"
#include "client/cli/figures/paper_loops.h"
#include "server/model/continuous_loop.h"

namespace mwidth::figures {
namespace {

// Gain margins of L(s) for +M and -M (eq. 15).
struct GainMargins {
  double positive = 0;
  double negative = 0;
};

GainMargins MarginsOf(const model::LoopParameters& loop, double mass) {
  const auto edges = model::ComputeContinuousMWidth(loop);
  return {model::GainMargin(edges, mass), model::GainMargin(edges, -mass)};
}

// The loop of Figure 4 with one parameter times a factor.
using Scaled = std::function<GainMargins(double factor)>;

GainMargins Scale(double RatioLoop::*parameter, double factor) {
  RatioLoop ratios;
  ratios.*parameter *= factor;
  return MarginsOf(ratios.Loop(), ratios.Mass());
}

GainMargins Scale(double model::LoopParameters::*parameter, double factor) {
  const RatioLoop ratios;
  auto loop = ratios.Loop();
  loop.*parameter *= factor;
  return MarginsOf(loop, ratios.Mass());
}

// d ln(gain margin) / d ln(parameter): +1 when the margin grows in proportion.
GainMargins Elasticities(const Scaled& scaled) {
  constexpr double kStep = 1e-4;
  const auto more = scaled(std::exp(kStep));
  const auto less = scaled(std::exp(-kStep));
  return {std::log(more.positive / less.positive) / (2 * kStep),
          std::log(more.negative / less.negative) / (2 * kStep)};
}

// Below a tenth, doubling the parameter changes the margin by less than 0.6 dB.
std::string Arrow(double elasticity) {
  constexpr double kSmall = 0.1;
  return std::abs(elasticity) < kSmall ? "-" : elasticity > 0 ? "↑" : "↓";
}

struct Parameter {
  std::string name;
  Scaled scaled;
  // What the paper's Table I says.
  std::string paper_positive;
  std::string paper_negative;
};

template <typename Owner>
Scaled Over(double Owner::*parameter) {
  return [parameter](double factor) { return Scale(parameter, factor); };
}

}  // namespace

plot::Table GainMarginTable() {
  const std::vector<Parameter> parameters = {
      {"M/m", Over(&RatioLoop::mass_ratio), "↓", "↓"},
      {"ω_n at fixed ζ", Over(&RatioLoop::natural_rad_per_s), "-", "↑"},
      {"ζ", Over(&RatioLoop::damping_ratio), "-", "↑"},
      {"T", Over(&RatioLoop::period_s), "↓", "-"},
      {"ω_0", Over(&RatioLoop::cutoff_rad_per_s), "↓", "↓"},
      {"k_h at fixed b_h", Over(&model::LoopParameters::hand_stiffness), "", ""},
      {"b_h at fixed k_h", Over(&model::LoopParameters::hand_damping), "", ""}};
  const RatioLoop ratios;
  const double critical_rad_per_s =
      2 * std::numbers::pi * model::ComputeContinuousMWidth(ratios.Loop()).upper.critical_hz;
  plot::Table table{
      .title = "Effect of parameters on the gain margin of L(s) (loop of Figure 4, 1000 Hz; ω_n/ω* = " +
               cli::Rounded(ratios.natural_rad_per_s / critical_rad_per_s, 2) + ")",
      .columns = {"parameter", "dlnGM/dlnp, M > 0", "effect, M > 0", "paper, M > 0", "dlnGM/dlnp, M < 0",
                  "effect, M < 0", "paper, M < 0"}};
  for (const auto& parameter : parameters) {
    const auto effect = Elasticities(parameter.scaled);
    table.rows.push_back({parameter.name, cli::Rounded(effect.positive, 3), Arrow(effect.positive),
                          parameter.paper_positive, cli::Rounded(effect.negative, 3), Arrow(effect.negative),
                          parameter.paper_negative});
  }
  return table;
}

}  // namespace mwidth::figures
