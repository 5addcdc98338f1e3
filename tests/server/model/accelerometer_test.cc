// A loop with an accelerometer against 50-digit vectors, closed forms, and its own closed-loop matrix.
#include "server/model/accelerometer.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <iostream>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>
#include <unsupported/Eigen/MatrixFunctions>
#include <vector>

#include "server/model/accelerometer_simulation.h"
#include "server/model/linear_estimator.h"
#include "server/model/low_pass.h"
#include "server/model/m_width.h"
#include "tests/server/model/model_loops.h"

namespace mwidth::model {
namespace {

LoopParameters TableTwoSensed(EstimatorKind kind, double bandwidth_hz) {
  LoopParameters loop = TableTwo();
  loop.estimator = kind;
  loop.accelerometer_bandwidth_hz = bandwidth_hz;
  return loop;
}

std::string Describe(const LoopParameters& loop) {
  std::ostringstream text;
  text.precision(17);
  text << loop.device_mass << ',' << loop.device_damping << ',' << loop.hand_mass << ',' << loop.hand_damping
       << ',' << loop.hand_stiffness << ',' << loop.period_s << ',' << loop.cutoff_hz << ',' << loop.delay_s
       << ',' << Name(loop.estimator) << ',' << loop.accelerometer_bandwidth_hz;
  return text.str();
}

struct VectorRow {
  LoopParameters loop;
  std::array<double, 3> rise{};
  Edge lower;
  Edge upper;
};

std::vector<VectorRow> ReadVectors() {
  std::ifstream file(TEST_DATA_DIR "/accelerometer_vectors.csv");
  std::string line;
  std::getline(file, line);
  std::vector<VectorRow> rows;
  while (std::getline(file, line)) {
    std::istringstream text(line);
    std::array<double, 17> v{};
    for (double& value : v) {
      std::string cell;
      std::getline(text, cell, ',');
      value = std::stod(cell);
    }
    const EstimatorKind kind =
        v[9] == 1 ? EstimatorKind::kFilteredAccelerometer : EstimatorKind::kAccelerometer;
    rows.push_back({.loop = {v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], kind, v[8]},
                    .rise = {v[10], v[11], v[12]},
                    .lower = {.mass = v[13], .critical_hz = v[15]},
                    .upper = {.mass = v[14], .critical_hz = v[16]}});
  }
  return rows;
}

TEST(Accelerometer, HasTheMWidthOfFiftyDigitArithmetic) {
  double worst = 0;
  const std::vector<VectorRow> rows = ReadVectors();
  ASSERT_EQ(rows.size(), 310U);
  for (const VectorRow& row : rows) {
    ASSERT_FALSE(Validate(row.loop).has_value());
    const MWidth m_width = ComputeMWidth(row.loop);
    EXPECT_LT(std::abs(m_width.lower.mass / row.lower.mass - 1), 1e-13) << Describe(row.loop);
    EXPECT_LT(std::abs(m_width.upper.mass / row.upper.mass - 1), 1e-13) << Describe(row.loop);
    EXPECT_LE(std::abs(m_width.lower.critical_hz - row.lower.critical_hz), 1e-13 * row.lower.critical_hz);
    EXPECT_LE(std::abs(m_width.upper.critical_hz - row.upper.critical_hz), 1e-13 * row.upper.critical_hz);
    worst = std::max({worst, std::abs(m_width.lower.mass / row.lower.mass - 1),
                      std::abs(m_width.upper.mass / row.upper.mass - 1)});
  }
  std::cout << "largest relative error of an edge " << worst << '\n';
}

TEST(Accelerometer, IsDiscretizedAsTheMatrixExponentialSays) {
  for (const VectorRow& row : ReadVectors()) {
    const SampledPlant plant = Discretize(row.loop);
    const SampledAcceleration acceleration = DiscretizeAcceleration(row.loop, plant);
    // How far the slowest pole of the plant is from z = 1: there rise[0] meets rise[1] w.
    const double q = plant.static_gap;
    const double slowest = q > 0 ? q / (q + plant.loss + std::sqrt(q)) : 0;
    EXPECT_NEAR(acceleration.rise[0], row.rise[0],
                1e-13 * (std::abs(row.rise[0]) + slowest * std::abs(row.rise[1])) + 1e-45)
        << Describe(row.loop);
    EXPECT_NEAR(acceleration.rise[1], row.rise[1], 1e-13 * std::abs(row.rise[1])) << Describe(row.loop);
    EXPECT_NEAR(acceleration.rise[2], row.rise[2], 1e-13 * std::abs(row.rise[2])) << Describe(row.loop);
  }
}

// Force to sensed acceleration is f_a/(mu (z - 1 + f_a)): one root, z = 1 - f_a - f_a M/mu.
TEST(Accelerometer, OnAFreeMassHasAClosedForm) {
  for (const double bandwidth_hz : {1.0, 30.0, 100.0, 1000.0, 1e5}) {
    LoopParameters loop = TableTwoSensed(EstimatorKind::kAccelerometer, bandwidth_hz);
    loop.device_damping = loop.hand_damping = loop.hand_stiffness = 0;
    const double gap = -std::expm1(-2 * std::numbers::pi * bandwidth_hz * loop.period_s);
    const MWidth m_width = ComputeMWidth(loop);
    EXPECT_NEAR(m_width.lower.mass / loop.device_mass, -1, 1e-15);
    EXPECT_NEAR(m_width.upper.mass / loop.device_mass / ((2 - gap) / gap), 1, 1e-13);
    EXPECT_EQ(m_width.lower.critical_hz, 0);
  }
}

// The closed loop's map from tick to tick: x, v and y by the exponential of their generator, then the
// estimate and the forces of the last four ticks. A released hand's position, on which nothing depends, is
// left out.
double SpectralRadius(const LoopParameters& loop, double mass) {
  const double moving = loop.device_mass + loop.hand_mass;
  const double sensor_rate = 2 * std::numbers::pi * loop.accelerometer_bandwidth_hz;
  Eigen::Matrix4d generator = Eigen::Matrix4d::Zero();
  generator(0, 1) = 1;
  generator.row(1) << -loop.hand_stiffness / moving, -(loop.device_damping + loop.hand_damping) / moving, 0,
      -1 / moving;
  generator.row(2) = sensor_rate * generator.row(1);
  generator(2, 2) = -sensor_rate;
  const double ticks = std::floor(loop.delay_s / loop.period_s + 1e-9);
  const double late_s = loop.period_s * (1 + ticks) - loop.delay_s;
  const Eigen::Matrix4d whole = (generator * loop.period_s).exp();
  const Eigen::Vector4d newest = (generator * late_s).exp().col(3);

  constexpr Eigen::Index kEstimate = 3;
  constexpr Eigen::Index kForces = 4;  // F_a(k-1), F_a(k-2) ..
  constexpr Eigen::Index kStates = 8;
  Eigen::MatrixXd map = Eigen::MatrixXd::Zero(kStates, kStates);
  const double kept = loop.estimator == EstimatorKind::kAccelerometer
                          ? 0
                          : std::exp(-2 * std::numbers::pi * loop.cutoff_hz * loop.period_s);
  map(kEstimate, kEstimate) = kept;
  map(kEstimate, 2) = 1 - kept;
  map.row(kForces) = mass * map.row(kEstimate);
  for (Eigen::Index i = kForces + 1; i < kStates; ++i) {
    map(i, i - 1) = 1;
  }
  map.topLeftCorner(3, 3) = whole.topLeftCorner(3, 3);
  const auto act = [&](Eigen::Index age, const Eigen::Vector3d& effect) {
    if (age == 0) {
      map.topRows(3) += effect * map.row(kForces);
    } else {
      map.col(kForces + age - 1).head(3) += effect;
    }
  };
  const auto age = static_cast<Eigen::Index>(ticks);
  act(age, newest.head(3));
  act(age + 1, whole.col(3).head(3) - newest.head(3));
  const Eigen::Index used = loop.hand_stiffness == 0 ? kStates - 1 : kStates;
  return map.bottomRightCorner(used, used).eigenvalues().cwiseAbs().maxCoeff();
}

// Everyday loops with each sensor, filter and delay.
std::vector<LoopParameters> Loops() {
  std::vector<LoopParameters> loops;
  for (const EstimatorKind kind : kAccelerometerKinds) {
    for (const double bandwidth_hz : {20.0, 150.0, 2000.0}) {
      for (const double delay_ticks : {0.0, 0.4, 1.0, 2.7}) {
        LoopParameters loop = TableTwoSensed(kind, bandwidth_hz);
        loop.delay_s = delay_ticks * loop.period_s;
        loops.push_back(loop);
        loop.cutoff_hz = 100;
        loop.hand_stiffness = 20;
        loop.hand_damping = 0.4;
        loops.push_back(loop);
        loop.hand_stiffness = 0;
        loops.push_back(loop);
      }
    }
  }
  return loops;
}

TEST(Accelerometer, LosesItsStabilityWhereTheClosedLoopMatrixDoes) {
  for (const LoopParameters& loop : Loops()) {
    const MWidth m_width = ComputeMWidth(loop);
    for (const double edge : {m_width.lower.mass, m_width.upper.mass}) {
      EXPECT_NEAR(SpectralRadius(loop, edge), 1, 1e-7) << Describe(loop);
      for (const double share : {0.1, 0.5, 0.9, 0.99}) {
        EXPECT_LT(SpectralRadius(loop, share * edge), 1) << Describe(loop) << " " << share * edge;
      }
      EXPECT_GT(SpectralRadius(loop, 1.01 * edge), 1) << Describe(loop) << " " << edge;
    }
  }
}

// How much further the device swings, after a push, in the second half of the time than in the first.
double Growth(const LoopParameters& loop, double mass) {
  constexpr int kTicks = 60000;
  AccelerometerSimulation device(loop);
  FirstOrderLowPass filter(FirstOrderLowPass::Factors(loop.period_s, loop.cutoff_hz));
  const bool filtered = loop.estimator == EstimatorKind::kFilteredAccelerometer;
  device.Reset(0, 1e-3, 0);
  double early = 0;
  double late = 0;
  for (int k = 0; k < kTicks; ++k) {
    const double estimate = filtered ? filter.Update(device.sensed()) : device.sensed();
    device.Command(mass * estimate);
    device.Advance(0);
    if (std::abs(estimate) > 1e100) {
      return 2;
    }
    double& peak = k < kTicks / 2 ? early : late;
    if (k >= kTicks / 4) {
      peak = std::max(peak, std::abs(device.sensed()));
    }
  }
  return late / early;
}

TEST(Accelerometer, DiesOutJustInsideAndGrowsJustOutsideInSimulation) {
  for (const LoopParameters& loop : Loops()) {
    if (loop.accelerometer_bandwidth_hz > 1000) {
      continue;  // hardly filtered: half of these loops ring for longer than this test
    }
    const MWidth m_width = ComputeMWidth(loop);
    for (const double edge : {m_width.lower.mass, m_width.upper.mass}) {
      EXPECT_LT(Growth(loop, 0.98 * edge), 0.99) << Describe(loop) << " " << edge;
      EXPECT_GT(Growth(loop, 1.02 * edge), 1.01) << Describe(loop) << " " << edge;
    }
  }
}

TEST(Accelerometer, HasFiniteEdgesForEveryLoopThatMovesWithinATick) {
  RandomLoops random(31);
  for (int i = 0; i < 20000; ++i) {
    LoopParameters loop{.device_mass = random.LogUniform(1e-6, 1e4),
                        .device_damping = random.LogUniform(1e-9, 1e4),
                        .hand_damping = random.LogUniform(1e-9, 1e4),
                        .hand_stiffness = i % 5 == 0 ? 0 : random.LogUniform(1e-6, 1e6),
                        .period_s = random.LogUniform(1e-5, 1e-2)};
    loop.cutoff_hz = random.LogUniform(1e-3, 0.5 / loop.period_s);
    loop.delay_s = i % 3 == 0 ? 0 : loop.period_s * random.Uniform(0, 3);
    loop.estimator = kAccelerometerKinds.at(static_cast<std::size_t>(i) % 2);
    loop.accelerometer_bandwidth_hz = random.LogUniform(0.1, 1e6);
    ASSERT_FALSE(Validate(loop).has_value());
    const MWidth m_width = ComputeMWidth(loop);
    ASSERT_FALSE(m_width.empty());
    // What damps a motion to e^-400 of it within a tick leaves nothing to sample.
    const double damping = (loop.device_damping + loop.hand_damping) * loop.period_s / loop.device_mass;
    for (const Edge& edge : {m_width.lower, m_width.upper}) {
      ASSERT_TRUE(std::isfinite(edge.mass) || damping > 400) << Describe(loop);
      ASSERT_GE(edge.critical_hz, 0) << Describe(loop);
      ASSERT_LE(edge.critical_hz, 0.5 / loop.period_s * (1 + 1e-15)) << Describe(loop);
    }
    ASSERT_LT(m_width.lower.mass, 0) << Describe(loop);
    ASSERT_GT(m_width.upper.mass, 0) << Describe(loop);
  }
}

TEST(Accelerometer, IsRefusedWithoutABandwidthAndByName) {
  LoopParameters loop = TableTwoSensed(EstimatorKind::kAccelerometer, 100);
  EXPECT_FALSE(Validate(loop).has_value());
  for (const double bandwidth_hz : {0.0, -1.0, 0.09, 1.1e6, std::nan("")}) {
    loop.accelerometer_bandwidth_hz = bandwidth_hz;
    const auto error = Validate(loop);
    ASSERT_TRUE(error.has_value()) << bandwidth_hz;
    EXPECT_EQ(error->parameter, "accelerometer_bandwidth_hz");
  }
  loop.estimator = EstimatorKind::kKalman;
  EXPECT_FALSE(Validate(loop).has_value());
}

TEST(Accelerometer, IsRefusedByWhatNeedsPositions) {
  const LoopParameters loop = TableTwoSensed(EstimatorKind::kFilteredAccelerometer, 100);
  EXPECT_TRUE(Runs(loop.estimator, loop.period_s, loop.cutoff_hz));
  EXPECT_THROW(EstimatorOf(loop), std::invalid_argument);
}

}  // namespace
}  // namespace mwidth::model
