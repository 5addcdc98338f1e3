#include "server/model/continuous_loop.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "tests/server/model/model_loops.h"

namespace mwidth::model {
namespace {

using std::numbers::pi;

// Figures 4, 5, 7 and 10 are drawn for these ratios: w_n = 100 rad/s, zeta = 0.5, w0 = 30 rad/s, 1 kHz.
LoopParameters FigureFour() {
  constexpr double kMass = 0.07;
  return {.device_mass = kMass,
          .hand_damping = 2 * 0.5 * 100 * kMass,
          .hand_stiffness = 100 * 100 * kMass,
          .period_s = 1e-3,
          .cutoff_hz = 30 / (2 * pi)};
}

double Decibels(double ratio) { return 20 * std::log10(ratio); }

TEST(ContinuousLoop, HasTheGainMarginsOfEquation12WithTwoZeros) {
  const LoopParameters loop = FigureFour();
  const MWidth m_width = ComputeContinuousMWidth(loop);
  EXPECT_NEAR(2 * pi * m_width.upper.critical_hz, 1199, 0.5);
  EXPECT_NEAR(2 * pi * m_width.lower.critical_hz, 106, 0.5);
  EXPECT_NEAR(Decibels(GainMargin(m_width, loop.device_mass)), 34.7, 0.05);
  EXPECT_NEAR(Decibels(GainMargin(m_width, -loop.device_mass)), 10.9, 0.05);
  const double w = 2 * pi * m_width.upper.critical_hz;
  EXPECT_NEAR(Decibels(std::abs(ContinuousLoop(loop, loop.device_mass, w / (2 * pi)))), -34.7, 0.05);
}

TEST(ContinuousLoop, BoundsTheMassesOfTableTwo) {
  const LoopParameters loop = TableTwo();
  const MWidth m_width = ComputeContinuousMWidth(loop);
  EXPECT_NEAR(m_width.lower.mass / loop.device_mass, -1.383, 0.0005);
  EXPECT_NEAR(m_width.upper.mass / loop.device_mass, 25.93, 0.005);
}

// Equation 12 in the paper's ratios, two zeros at the origin, term by term.
TEST(ContinuousLoop, EqualsEquation12InRatios) {
  const LoopParameters loop = TableTwo();
  const double m = loop.device_mass;
  const double natural = std::sqrt(loop.hand_stiffness / m);  // 13
  const double zeta =
      (loop.device_damping + loop.hand_damping) / (2 * std::sqrt(loop.hand_stiffness * m));  // 14
  const double cutoff = 2 * pi * loop.cutoff_hz;
  for (const double frequency_hz : {0.01, 1.0, 15.9, 80.0, 490.0}) {
    const std::complex<double> s(0, 2 * pi * frequency_hz);
    const std::complex<double> expected = 3.0 / (s * s + 2 * zeta * natural * s + natural * natural) *
                                          (4.0 * s * s / std::pow(s * loop.period_s + 2.0, 2)) *
                                          (cutoff / (s + cutoff)) * std::exp(-s * loop.period_s / 2.0);
    const std::complex<double> found = ContinuousLoop(loop, 3 * m, frequency_hz);
    EXPECT_LT(std::abs(found - expected), 1e-13 * std::abs(expected)) << frequency_hz;
  }
}

TEST(ContinuousLoop, DelayTurnsThePhaseOnly) {
  LoopParameters loop = TableTwo();
  const std::complex<double> prompt = ContinuousLoop(loop, 1, 40);
  loop.delay_s = 2.5e-3;
  const std::complex<double> late = ContinuousLoop(loop, 1, 40);
  EXPECT_LT(std::abs(late - prompt * std::polar(1.0, -2 * pi * 40 * 2.5e-3)), 1e-14 * std::abs(prompt));
}

struct Vector {
  LoopParameters loop;
  Edge lower;
  Edge upper;
};

std::vector<Vector> ReadVectors() {
  std::ifstream file(TEST_DATA_DIR "/continuous_vectors.csv");
  std::string line;
  std::getline(file, line);
  std::vector<Vector> vectors;
  while (std::getline(file, line)) {
    std::istringstream fields(line);
    std::vector<double> values;
    for (std::string field; std::getline(fields, field, ',');) {
      values.push_back(std::stod(field));
    }
    vectors.push_back({.loop = {.device_mass = values.at(0),
                                .device_damping = values.at(1),
                                .hand_mass = values.at(2),
                                .hand_damping = values.at(3),
                                .hand_stiffness = values.at(4),
                                .period_s = values.at(5),
                                .cutoff_hz = values.at(6),
                                .delay_s = values.at(7)},
                       .lower = {.mass = values.at(8), .critical_hz = values.at(9)},
                       .upper = {.mass = values.at(10), .critical_hz = values.at(11)}});
  }
  return vectors;
}

TEST(ContinuousLoop, HasTheEdgesOfTheArgumentPrincipleIn50Digits) {
  const std::vector<Vector> vectors = ReadVectors();
  ASSERT_GE(vectors.size(), 100U);
  for (const Vector& vector : vectors) {
    const MWidth m_width = ComputeContinuousMWidth(vector.loop);
    ASSERT_FALSE(m_width.empty());
    EXPECT_NEAR(m_width.lower.mass / vector.lower.mass, 1, 1e-12);
    EXPECT_NEAR(m_width.upper.mass / vector.upper.mass, 1, 1e-12);
    EXPECT_NEAR(m_width.lower.critical_hz / vector.lower.critical_hz, 1, 1e-12);
    EXPECT_NEAR(m_width.upper.critical_hz / vector.upper.critical_hz, 1, 1e-12);
  }
}

TEST(ContinuousLoop, IsMinusOneAtItsEdges) {
  RandomLoops loops(7);
  for (int i = 0; i < 300; ++i) {
    const LoopParameters loop = loops.Next();
    const MWidth m_width = ComputeContinuousMWidth(loop);
    for (const Edge& edge : {m_width.lower, m_width.upper}) {
      EXPECT_LT(std::abs(ContinuousLoop(loop, edge.mass, edge.critical_hz) + 1.0), 1e-9) << "loop " << i;
    }
  }
}

TEST(ContinuousLoop, LetsAFreeMassWithoutFrictionLoseAllOfItself) {
  LoopParameters loop = TableTwo();
  loop.device_damping = loop.hand_damping = loop.hand_stiffness = 0;
  loop.hand_mass = 0.03;
  const MWidth m_width = ComputeContinuousMWidth(loop);
  EXPECT_DOUBLE_EQ(m_width.lower.mass, -0.1);
  EXPECT_EQ(m_width.lower.critical_hz, 0);
  // A hair of friction changes little.
  loop.device_damping = 1e-9;
  EXPECT_NEAR(ComputeContinuousMWidth(loop).lower.mass, -0.1, 1e-6);
  EXPECT_NEAR(ComputeContinuousMWidth(loop).upper.mass, m_width.upper.mass, 1e-6);
}

TEST(ContinuousLoop, HasNoStableMassWithASpringAndNoDamping) {
  LoopParameters loop = TableTwo();
  loop.device_damping = loop.hand_damping = 0;
  const MWidth m_width = ComputeContinuousMWidth(loop);
  EXPECT_TRUE(m_width.empty());
  EXPECT_FALSE(m_width.Contains(0));
}

}  // namespace
}  // namespace mwidth::model
