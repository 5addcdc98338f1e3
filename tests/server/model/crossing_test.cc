#include "server/model/crossing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <vector>

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

double FilterGap(const LoopParameters& loop) {
  return -std::expm1(-2 * std::numbers::pi * loop.cutoff_hz * loop.period_s);
}

// The loop for a unit mass, term by term as the paper has it.
std::complex<double> OpenLoop(const LoopParameters& loop, double angle) {
  const std::complex<double> z = std::polar(1.0, angle);
  const std::complex<double> w = z - 1.0;
  const SampledPlant plant = Discretize(loop);
  const double f = FilterGap(loop);
  const auto difference = w * w / (loop.period_s * loop.period_s * z * z);
  const auto numerator = plant.hold[0] * z * z + plant.hold[1] * z + plant.hold[2];
  const auto denominator = w * w + (plant.static_gap + plant.loss) * w + plant.static_gap;
  return difference * f * z / (w + f) * plant.gain * numerator /
         (denominator * std::pow(z, 1 + plant.delay_ticks));
}

std::vector<Crossing> Sorted(const LoopParameters& loop) {
  const Crossings crossings = FindCrossings(Discretize(loop), FilterGap(loop), loop.device_mass);
  std::vector<Crossing> sorted(crossings.begin(), crossings.end());
  std::sort(sorted.begin(), sorted.end(),
            [](const Crossing& a, const Crossing& b) { return a.half_sine_squared < b.half_sine_squared; });
  return sorted;
}

TEST(Crossings, PutARootOfTheCharacteristicEquationOnTheCircle) {
  for (const double ticks : {0.0, 0.4, 1.0, 1.5, 2.0, 2.9, 3.0}) {
    LoopParameters loop = kPaper;
    loop.delay_s = ticks * loop.period_s;
    for (const Crossing& crossing : Sorted(loop)) {
      const double angle = 2 * std::asin(std::sqrt(crossing.half_sine_squared));
      EXPECT_LT(std::abs(1.0 + crossing.mass * OpenLoop(loop, angle)), 1e-11) << ticks << " " << angle;
    }
  }
}

TEST(Crossings, AreAllThereAre) {
  for (const double ticks : {0.0, 0.4, 1.0, 1.5, 2.0, 2.9, 3.0}) {
    LoopParameters loop = kPaper;
    loop.delay_s = ticks * loop.period_s;
    const std::vector<Crossing> crossings = Sorted(loop);
    // The open loop's imaginary part changes sign once between two neighbours, and z = -1 is the last.
    size_t changes = 0;
    double last = OpenLoop(loop, 1e-4).imag();
    for (int i = 2; i < 30000; ++i) {
      const double value = OpenLoop(loop, std::numbers::pi * i / 30000).imag();
      changes += (value < 0) != (last < 0) ? 1 : 0;
      last = value;
    }
    EXPECT_EQ(crossings.size(), changes + 1) << ticks;
    EXPECT_EQ(crossings.back().half_sine_squared, 1);
  }
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
