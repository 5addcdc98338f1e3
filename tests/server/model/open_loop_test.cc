#include "server/model/open_loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "server/model/m_width.h"
#include "server/model/unit_circle.h"
#include "tests/server/model/model_loops.h"
#include "tests/server/model/reference_open_loop.h"

namespace mwidth::model {
namespace {

OpenLoop OpenLoopOf(const LoopParameters& loop, double mass) {
  const SampledPlant plant = Discretize(loop);
  if (IsAccelerometer(loop.estimator)) {
    return {plant, DiscretizeAcceleration(loop, plant), AccelerometerFilter(loop),
            loop.device_mass + loop.hand_mass, mass};
  }
  return {plant, EstimatorOf(loop), mass};
}

// Loops with all estimators: damped, released, released without friction.
std::vector<LoopParameters> Loops() {
  RandomLoops random(21);
  std::vector<LoopParameters> loops;
  for (int i = 0; i < 150; ++i) {
    LoopParameters loop = random.Next();
    loop.estimator = kAllEstimatorKinds.at(static_cast<std::size_t>(i) % kAllEstimatorKinds.size());
    if (i % 5 == 3) {
      loop.hand_stiffness = 0;
    }
    if (i % 5 == 4) {
      loop.hand_stiffness = loop.hand_damping = loop.device_damping = 0;
    }
    loops.push_back(loop);
  }
  return loops;
}

TEST(OpenLoop, EqualsTheEquationsInFiftyDigits) {
  for (const LoopParameters& loop : Loops()) {
    const double mass = 0.7 * ComputeMWidth(loop).upper.mass;
    const OpenLoop open = OpenLoopOf(loop, mass);
    const ReferenceOpenLoop<Real> reference(loop);
    for (const double angle : {1e-4, 0.02, 0.5, 1.7, 3.0}) {
      const double half_sine = std::sin(angle / 2);
      const auto exact = reference.Value(mass, Real(angle));
      const std::complex<double> expected(static_cast<double>(exact.real()),
                                          static_cast<double>(exact.imag()));
      // A rounded angle may be off a sharp resonance by its width's share.
      EXPECT_LT(std::abs(open.Ratio(half_sine * half_sine) - expected), 1e-9 * std::abs(expected));
    }
  }
}

TEST(OpenLoop, SizesOnItsArcsAreThoseOfItsValues) {
  for (const LoopParameters& loop : Loops()) {
    const MWidth m_width = ComputeMWidth(loop);
    for (const double mass : {0.9 * m_width.upper.mass, 0.9 * m_width.lower.mass}) {
      const OpenLoop open = OpenLoopOf(loop, mass);
      for (const OpenLoopOnArc& on : open.Arcs()) {
        // A Butterworth filter takes the step away at z = -1: there only the size elsewhere measures the
        // rounding.
        double largest_step = 0;
        for (const double x : {1e-3, 0.2, 0.5, 0.8, 1.0}) {
          largest_step = std::max(largest_step, open.StepSize(on.arc.HalfSineSquared(x)));
        }
        for (const double x : {1e-3, 0.2, 0.5, 0.8, 1.0}) {
          const double s = on.arc.HalfSineSquared(x);
          const OpenLoopValue value = open.At(s);
          const double size = std::norm(value.top) + std::norm(value.bottom);
          EXPECT_NEAR(Evaluate(on.top_squared, x), std::norm(value.top), 1e-9 * size);
          EXPECT_NEAR(Evaluate(on.bottom_squared, x), std::norm(value.bottom), 1e-9 * size);
          EXPECT_NEAR(Evaluate(on.sum_squared, x), std::norm(value.top + value.bottom), 1e-9 * size);
          if (IsAccelerometer(loop.estimator)) {
            continue;
          }
          const double step = open.StepSize(s);
          EXPECT_NEAR(Evaluate(on.step_squared, x), step * step, 1e-11 * largest_step * largest_step);
          // Im L has the same sign up to a factor that keeps its own, if it is not lost in rounding.
          const double turn = std::imag(value.top * std::conj(value.bottom));
          if (s < 1 && std::abs(turn) > 1e-7 * std::abs(value.top * value.bottom)) {
            EXPECT_EQ(Evaluate(on.imaginary, x) * -mass > 0, turn > 0);
          }
        }
      }
    }
  }
}

TEST(OpenLoop, ArcsCoverTheUpperHalfAndShortenAroundASharpResonance) {
  EXPECT_EQ(OpenLoopOf(TableTwo(), 1).Arcs().size(), 1U);
  LoopParameters sharp = TableTwo();
  sharp.hand_damping = sharp.device_damping = 1e-4;
  const SampledPlant plant = Discretize(sharp);
  const double resonance = plant.static_gap / 4;
  double end = 0;
  double shortest = 1;
  for (const OpenLoopOnArc& on : OpenLoopOf(sharp, 1).Arcs()) {
    EXPECT_EQ(on.arc.low, end);
    EXPECT_GT(on.arc.high, on.arc.low);
    end = on.arc.high;
    shortest = std::min(shortest, on.arc.high - on.arc.low);
  }
  EXPECT_EQ(end, 1);
  EXPECT_LT(shortest, 8 * resonance * plant.loss / std::sqrt(plant.static_gap));
}

TEST(OpenLoop, AtStandstillIsNothingUnlessOnlyMassesResist) {
  LoopParameters loop = TableTwo();
  EXPECT_EQ(OpenLoopOf(loop, 0.5).Ratio(0), 0.0);
  loop.hand_stiffness = 0;
  EXPECT_EQ(OpenLoopOf(loop, 0.5).Ratio(0), 0.0);
  loop.hand_damping = loop.device_damping = 0;
  EXPECT_NEAR(OpenLoopOf(loop, 0.5).Ratio(0).real(), 0.5 / loop.device_mass, 1e-13);
  EXPECT_EQ(OpenLoopOf(loop, 0.5).Ratio(0).imag(), 0);
}

// What delay_margin.h says a later step of the force does to L.
TEST(OpenLoop, ChangesWithDelayNoMoreThanItsStepSizeAllows) {
  RandomLoops random(22);
  double closest = 0;
  for (int i = 0; i < 2000; ++i) {
    LoopParameters loop = random.Next();
    loop.delay_s = loop.period_s * random.Uniform(0, 2);
    const double later = random.LogUniform(1e-4, 1);
    const double alpha_twice =
        (loop.device_damping + loop.hand_damping) * loop.period_s / (loop.device_mass + loop.hand_mass);
    const double kappa =
        loop.hand_stiffness * loop.period_s * loop.period_s / (loop.device_mass + loop.hand_mass);
    const double reach = std::min({1.0, 2 / alpha_twice, 2 / std::sqrt(kappa)});
    const OpenLoop before = OpenLoopOf(loop, 1);
    loop.delay_s += later * loop.period_s;
    const OpenLoop after = OpenLoopOf(loop, 1);
    const double s = random.LogUniform(1e-8, 1);
    const double allowed = later * reach * before.StepSize(s) / std::abs(before.At(s).bottom);
    const double change = std::abs(after.Ratio(s) - before.Ratio(s));
    EXPECT_LE(change, allowed * (1 + 1e-9) + 1e-12 * std::abs(before.Ratio(s)));
    closest = std::max(closest, change / allowed);
  }
  EXPECT_GT(closest, 0.99);
}

TEST(OpenLoop, RefusesWhatIsNoEstimatorOfAcceleration) {
  const SampledPlant plant = Discretize(TableTwo());
  EXPECT_THROW(OpenLoop(plant, {.numerator = {0, 1, 1}, .denominator = {1}}, 1), std::invalid_argument);
  EXPECT_THROW(OpenLoop(plant, {.numerator = {1, 0, 1}, .denominator = {1}}, 1), std::invalid_argument);
  EXPECT_THROW(OpenLoop(plant, {.numerator = {0, 0}, .denominator = {1}}, 1), std::invalid_argument);
  EXPECT_THROW(OpenLoop(plant, {.numerator = {0, 0, 1}, .denominator = {}}, 1), std::invalid_argument);
  const DifferencePolynomial long_one(OpenLoop::kMaxEstimatorDegree + 2, 1.0);
  EXPECT_THROW(OpenLoop(plant, {.numerator = {0, 0, 1}, .denominator = long_one}, 1), std::invalid_argument);
}

}  // namespace
}  // namespace mwidth::model
