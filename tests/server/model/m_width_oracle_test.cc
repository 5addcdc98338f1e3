// The M-width against the closed loop's poles, and against 50-digit vectors.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iostream>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "server/model/m_width.h"
#include "tests/server/model/closed_loop.h"

namespace mwidth::model {
namespace {

class RandomLoops {
 public:
  explicit RandomLoops(unsigned seed) : random_(seed), kinds_(seed) {}

  // Devices and hands as they are.
  LoopParameters Next(double period_min_s) {
    LoopParameters loop = Sampling(period_min_s, 0.3);
    const bool released = OneIn(8);
    loop.device_mass = LogUniform(1e-3, 1e2);
    loop.device_damping = released && OneIn(3) ? 0 : LogUniform(1e-4, 10);
    loop.hand_mass = OneIn(3) ? LogUniform(1e-3, 1) : 0;
    loop.hand_damping = released && OneIn(2) ? 0 : LogUniform(1e-2, 300);
    loop.hand_stiffness = released ? 0 : LogUniform(1, 3e4);
    return loop;
  }

  // Anything that Validate allows: also sampled below the natural frequency, damped away within a tick,
  // hardly filtered and hardly not.
  LoopParameters NextOfAll() {
    LoopParameters loop = Sampling(1e-5, 1e-3);
    loop.device_mass = LogUniform(1e-6, 1e4);
    loop.device_damping = OneIn(5) ? 0 : LogUniform(1e-9, 1e4);
    loop.hand_mass = OneIn(2) ? LogUniform(1e-6, 1e4) : 0;
    loop.hand_damping = LogUniform(1e-9, 1e4);
    loop.hand_stiffness = OneIn(5) ? 0 : LogUniform(1e-6, 1e6);
    return loop;
  }

 private:
  LoopParameters Sampling(double period_min_s, double cutoff_min_hz) {
    LoopParameters loop;
    loop.period_s = LogUniform(period_min_s, 1e-2);
    loop.cutoff_hz = LogUniform(cutoff_min_hz, 0.5 / loop.period_s);
    if (!OneIn(3)) {
      loop.delay_s = loop.period_s * (OneIn(3) ? std::floor(Uniform(0, 4)) : Uniform(0, 3));
    }
    loop.estimator = kEstimatorKinds.at(kinds_() % kEstimatorKinds.size());
    loop.cutoff_hz = std::min(loop.cutoff_hz, CutoffRangeOf(loop.estimator).max / loop.period_s);
    return loop;
  }
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  double LogUniform(double low, double high) { return low * std::pow(high / low, Uniform(0, 1)); }
  bool OneIn(int n) { return std::uniform_int_distribution<int>(1, n)(random_) == 1; }

  std::mt19937_64 random_;
  std::mt19937_64 kinds_;
};

std::string Describe(const LoopParameters& loop) {
  std::ostringstream text;
  text.precision(17);
  text << loop.device_mass << ',' << loop.device_damping << ',' << loop.hand_mass << ',' << loop.hand_damping
       << ',' << loop.hand_stiffness << ',' << loop.period_s << ',' << loop.cutoff_hz << ',' << loop.delay_s
       << ',' << Name(loop.estimator);
  return text.str();
}

TEST(MWidthOracle, JuryFindsTheLoopStableInsideAndUnstableOutside) {
  RandomLoops loops(11);
  for (int i = 0; i < 500; ++i) {
    const LoopParameters loop = i % 2 == 0 ? loops.Next(1e-5) : loops.NextOfAll();
    ASSERT_FALSE(Validate(loop).has_value());
    const MWidth m_width = ComputeMWidth(loop);
    const ClosedLoop closed(loop);
    for (const double edge : {m_width.lower.mass, m_width.upper.mass}) {
      ASSERT_TRUE(std::isfinite(edge)) << Describe(loop);
      EXPECT_FALSE(IsStableByJury(closed.Characteristic(edge * (1 + 1e-9)))) << Describe(loop);
      // All the way, not only next to the edge: the interval is the connected one.
      for (const double share : {1 - 1e-9, 0.99, 0.9, 0.7, 0.5, 0.2, 0.03}) {
        EXPECT_TRUE(IsStableByJury(closed.Characteristic(edge * share))) << share << " " << Describe(loop);
      }
    }
  }
}

TEST(MWidthOracle, EigenvaluesAgreeWhereDoublePrecisionCanTell) {
  RandomLoops loops(12);
  for (int i = 0; i < 500; ++i) {
    const LoopParameters loop = loops.Next(1e-3);
    const MWidth m_width = ComputeMWidth(loop);
    const ClosedLoop closed(loop);
    for (const double edge : {m_width.lower.mass, m_width.upper.mass}) {
      const double inside = SpectralRadius(closed.Characteristic(edge * 0.99));
      const double outside = SpectralRadius(closed.Characteristic(edge * 1.01));
      EXPECT_LT(inside, outside) << Describe(loop);
      // Slow poles within the rounding of a companion matrix of the circle prove nothing.
      EXPECT_LT(inside, 1 + 1e-7) << Describe(loop);
      EXPECT_GT(outside, 1 - 1e-7) << Describe(loop);
    }
  }
}

TEST(MWidthOracle, EdgesAreFiniteOnBothSidesOfZeroForEveryValidLoop) {
  RandomLoops loops(14);
  for (int i = 0; i < 100000; ++i) {
    const LoopParameters loop = loops.NextOfAll();
    const MWidth m_width = ComputeMWidth(loop);
    ASSERT_FALSE(m_width.empty()) << Describe(loop);
    ASSERT_LT(m_width.lower.mass, 0) << Describe(loop);
    ASSERT_GT(m_width.upper.mass, 0) << Describe(loop);
    for (const Edge& edge : {m_width.lower, m_width.upper}) {
      ASSERT_TRUE(std::isfinite(edge.mass)) << Describe(loop);
      ASSERT_GE(edge.critical_hz, 0) << Describe(loop);
      ASSERT_LE(edge.critical_hz, 0.5 / loop.period_s * (1 + 1e-15)) << Describe(loop);
    }
  }
}

TEST(MWidthOracle, TheCriticalFrequencyIsThatOfThePoleOnTheCircle) {
  RandomLoops loops(13);
  for (int i = 0; i < 200; ++i) {
    const LoopParameters loop = i % 2 == 0 ? loops.Next(1e-5) : loops.NextOfAll();
    const MWidth m_width = ComputeMWidth(loop);
    const ClosedLoop closed(loop);
    for (const Edge& edge : {m_width.lower, m_width.upper}) {
      // The characteristic polynomial at z = e^(jt), over what its terms would sum to without cancelling.
      Real re = 0;
      Real im = 0;
      Real size = 0;
      const Real angle = 2 * boost::math::constants::pi<Real>() * edge.critical_hz * loop.period_s;
      const RealPolynomial polynomial = closed.Characteristic(edge.mass);
      for (std::size_t k = 0; k < polynomial.size(); ++k) {
        re += polynomial[k] * cos(angle * k);
        im += polynomial[k] * sin(angle * k);
        size += abs(polynomial[k]);
      }
      EXPECT_LT(static_cast<double>(hypot(re, im) / size), 1e-14) << Describe(loop);
    }
  }
}

struct VectorRow {
  LoopParameters loop;
  Edge lower;
  Edge upper;
};

std::vector<VectorRow> ReadVectors() {
  std::ifstream file(TEST_DATA_DIR "/m_width_vectors.csv");
  std::string line;
  std::getline(file, line);
  std::vector<VectorRow> rows;
  while (std::getline(file, line)) {
    std::istringstream text(line);
    std::string cell;
    const auto number = [&] {
      std::getline(text, cell, ',');
      return std::stod(cell);
    };
    VectorRow row;
    for (double* value :
         {&row.loop.device_mass, &row.loop.device_damping, &row.loop.hand_mass, &row.loop.hand_damping,
          &row.loop.hand_stiffness, &row.loop.period_s, &row.loop.cutoff_hz, &row.loop.delay_s}) {
      *value = number();
    }
    std::getline(text, cell, ',');
    row.loop.estimator = EstimatorNamed(cell).value();
    for (double* value : {&row.lower.mass, &row.upper.mass, &row.lower.critical_hz, &row.upper.critical_hz}) {
      *value = number();
    }
    rows.push_back(row);
  }
  return rows;
}

TEST(MWidthOracle, EqualsFiftyDigitArithmetic) {
  double worst_mass = 0;
  double worst_frequency = 0;
  const std::vector<VectorRow> rows = ReadVectors();
  ASSERT_EQ(rows.size(), 2500U);
  for (const VectorRow& row : rows) {
    const MWidth m_width = ComputeMWidth(row.loop);
    for (const auto& [actual, expected] :
         {std::pair{m_width.lower, row.lower}, std::pair{m_width.upper, row.upper}}) {
      const double mass_error = std::abs(actual.mass / expected.mass - 1);
      EXPECT_LT(mass_error, 1e-13) << Describe(row.loop);
      const double frequency_error = std::abs(actual.critical_hz - expected.critical_hz);
      EXPECT_LE(frequency_error, 1e-13 * expected.critical_hz) << Describe(row.loop);
      worst_mass = std::max(worst_mass, mass_error);
      if (expected.critical_hz > 0) {
        worst_frequency = std::max(worst_frequency, frequency_error / expected.critical_hz);
      }
    }
  }
  std::cout << "largest relative error of an edge " << worst_mass << ", of a critical frequency "
            << worst_frequency << '\n';
}

}  // namespace
}  // namespace mwidth::model
