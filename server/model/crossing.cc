#include "server/model/crossing.h"

#include <array>
#include <cstddef>

#include "server/model/crossing_equation.h"
#include "server/model/unit_circle.h"

namespace mwidth::model {
namespace {

void Add(Crossings& crossings, const CrossingEquation& equation, double half_sine_squared) noexcept {
  crossings.found[static_cast<size_t>(crossings.count++)] = {
      .mass = equation.MassAt(PointAt(half_sine_squared)), .half_sine_squared = half_sine_squared};
}

void AddIsolatedCrossings(Crossings& crossings, const CrossingEquation& equation) noexcept {
  Form form{};
  const int degree = equation.DisagreementForm(form);
  Form bernstein{};
  Form slope{};
  double binomial = 1;
  for (int i = 0; i <= degree; ++i) {
    const auto k = static_cast<size_t>(i);
    bernstein[k] = form[k] / binomial;
    binomial = binomial * (degree - i) / (i + 1);
    slope[k] = i < degree ? (i + 1) * form[k + 1] - (degree - i) * form[k] : 0;
  }
  for (const RootBracket& bracket : IsolateRoots({bernstein.data(), static_cast<size_t>(degree) + 1})) {
    // The value comes from the factors, not from the expanded polynomial: it carries less rounding.
    const double root = RefineRoot(bracket, [&](double x) {
      const CirclePoint at = PointAt(x);
      return ValueAndSlope{equation.Disagreement(at), Evaluate(slope, degree - 1, at)};
    });
    Add(crossings, equation, root);
  }
}

Crossings CrossingsOf(const CrossingEquation& equation, bool lossless, double moving_mass) noexcept {
  Crossings crossings;
  crossings.found[0] = {.mass = equation.MassAtHalfSampleRate(), .half_sine_squared = 1};
  crossings.count = 1;
  if (lossless) {
    // A free mass without friction: at rest nothing but the sum of the masses resists.
    crossings.found[1] = {.mass = -moving_mass, .half_sine_squared = 0};
    crossings.count = 2;
  }
  AddIsolatedCrossings(crossings, equation);
  return crossings;
}

}  // namespace

Crossings FindCrossings(const SampledPlant& plant, const EstimatorFactors& estimator,
                        double moving_mass) noexcept {
  return CrossingsOf(CrossingEquation(plant, estimator, moving_mass), plant.loss == 0, moving_mass);
}

Crossings FindCrossings(const SampledPlant& plant, const SampledAcceleration& acceleration,
                        const EstimatorFactors& factors, double moving_mass) noexcept {
  return CrossingsOf(CrossingEquation(plant, acceleration, factors, moving_mass), plant.loss == 0,
                     moving_mass);
}

}  // namespace mwidth::model
