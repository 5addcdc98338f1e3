#include "server/model/crossing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

#include "server/model/estimator.h"
#include "tests/server/model/reference_estimator.h"

namespace mwidth::model {
namespace {

constexpr LoopParameters kPaper{.device_mass = 0.07,
                                .device_damping = 0.005,
                                .hand_mass = 0,
                                .hand_damping = 5,
                                .hand_stiffness = 700,
                                .period_s = 1e-3,
                                .cutoff_hz = 10,
                                .delay_s = 0};

// The loop for a unit mass, term by term as the paper has it.
class OpenLoop {
 public:
  explicit OpenLoop(const LoopParameters& loop)
      : period_s_(loop.period_s), plant_(Discretize(loop)), estimator_(EstimatorIn50Digits(loop)) {}

  std::complex<double> operator()(double angle) const {
    const std::complex<double> z = std::polar(1.0, angle);
    const std::complex<double> w = z - 1.0;
    const auto difference = w * w / (period_s_ * period_s_);
    const auto numerator = plant_.hold[0] * z * z + plant_.hold[1] * z + plant_.hold[2];
    const auto denominator = w * w + (plant_.static_gap + plant_.loss) * w + plant_.static_gap;
    return difference * Value(estimator_.numerator, z) / Value(estimator_.denominator, z) * plant_.gain *
           numerator / (denominator * std::pow(z, 1 + plant_.delay_ticks));
  }

 private:
  static std::complex<double> Value(const RealPolynomial& polynomial, const std::complex<double>& z) {
    std::complex<double> value = 0;
    for (auto coefficient = polynomial.rbegin(); coefficient != polynomial.rend(); ++coefficient) {
      value = value * z + static_cast<double>(*coefficient);
    }
    return value;
  }

  double period_s_;
  SampledPlant plant_;
  ReferenceEstimator estimator_;
};

// Each estimator with each delay, and with a hand, a released hand, and nothing but a free mass.
std::vector<LoopParameters> Loops() {
  std::vector<LoopParameters> loops;
  for (const EstimatorKind kind : kEstimatorKinds) {
    for (const double ticks : {0.0, 0.4, 1.0, 1.5, 2.0, 2.9, 3.0}) {
      for (const double cutoff_hz : {10.0, 200.0}) {
        LoopParameters loop = kPaper;
        loop.estimator = kind;
        loop.delay_s = ticks * loop.period_s;
        loop.cutoff_hz = cutoff_hz;
        loops.push_back(loop);
        loop.hand_stiffness = loop.hand_damping = 0;
        loops.push_back(loop);
        loop.device_damping = 0;
        loops.push_back(loop);
      }
    }
  }
  return loops;
}

std::string Describe(const LoopParameters& loop) {
  return std::string(Name(loop.estimator)) + " " + std::to_string(loop.cutoff_hz) + " Hz, delay " +
         std::to_string(loop.delay_s / loop.period_s) + ", damping " +
         std::to_string(loop.device_damping + loop.hand_damping);
}

std::vector<Crossing> Sorted(const LoopParameters& loop) {
  const Crossings crossings = FindCrossings(
      Discretize(loop), FactorsOf(loop.estimator, loop.period_s, loop.cutoff_hz), loop.device_mass);
  std::vector<Crossing> sorted(crossings.begin(), crossings.end());
  std::sort(sorted.begin(), sorted.end(),
            [](const Crossing& a, const Crossing& b) { return a.half_sine_squared < b.half_sine_squared; });
  return sorted;
}

TEST(Crossings, PutARootOfTheCharacteristicEquationOnTheCircle) {
  for (const LoopParameters& loop : Loops()) {
    const OpenLoop open_loop(loop);
    for (const Crossing& crossing : Sorted(loop)) {
      const double angle = 2 * std::asin(std::sqrt(crossing.half_sine_squared));
      if (std::isfinite(crossing.mass) && angle > 0) {
        EXPECT_LT(std::abs(1.0 + crossing.mass * open_loop(angle)), 1e-9) << Describe(loop) << " " << angle;
      }
    }
  }
}

TEST(Crossings, AreAllThereAre) {
  for (const LoopParameters& loop : Loops()) {
    const OpenLoop open_loop(loop);
    const std::vector<Crossing> crossings = Sorted(loop);
    // The open loop's imaginary part changes sign once between two neighbours, and z = -1 is the last. A free
    // mass has one more at rest.
    size_t expected = loop.device_damping + loop.hand_damping > 0 ? 1 : 2;
    double last = open_loop(1e-3).imag();
    for (int i = 10; i < 30000; ++i) {
      const double value = open_loop(std::numbers::pi * i / 30000).imag();
      expected += (value < 0) != (last < 0) ? 1 : 0;
      last = value;
    }
    EXPECT_EQ(crossings.size(), expected) << Describe(loop);
    EXPECT_EQ(crossings.back().half_sine_squared, 1);
  }
}

TEST(Crossings, AtHalfTheSampleRateNeedAnInfiniteMassWhereTheEstimatorHasAZero) {
  LoopParameters loop = kPaper;
  loop.estimator = EstimatorKind::kButterworth;
  EXPECT_TRUE(std::isinf(Sorted(loop).back().mass));
  loop.estimator = EstimatorKind::kKalman;
  EXPECT_TRUE(std::isfinite(Sorted(loop).back().mass));
}

TEST(Crossings, OfAFreeMassBeginAtRestWhereOnlyTheSumOfMassesResists) {
  LoopParameters loop = kPaper;
  loop.device_damping = loop.hand_damping = loop.hand_stiffness = 0;
  const std::vector<Crossing> crossings = Sorted(loop);
  EXPECT_EQ(crossings.front().half_sine_squared, 0);
  EXPECT_EQ(crossings.front().mass, -0.07);
}

}  // namespace
}  // namespace mwidth::model
