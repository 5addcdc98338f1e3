#include "server/model/estimator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

namespace mwidth::model {
namespace {

constexpr double kPeriodS = 1e-3;
constexpr double kCutoffHz = 10;

// Eqs. 3 and 4 written out as one sum over the whole past: no recursion in common with the estimator.
double AccelerationBySum(const std::vector<double>& positions, std::size_t k) {
  const auto x = [&](int64_t i) -> long double {
    return positions[static_cast<std::size_t>(std::max<int64_t>(i, 0))];
  };
  const long double a = std::exp(-2 * std::numbers::pi_v<long double> * kCutoffHz * kPeriodS);
  long double sum = 0;
  for (int64_t i = 0; i <= static_cast<int64_t>(k); ++i) {
    const int64_t n = static_cast<int64_t>(k) - i;
    const long double second_difference = (x(n) - 2 * x(n - 1) + x(n - 2)) / (kPeriodS * kPeriodS);
    sum += (1 - a) * std::pow(a, static_cast<long double>(i)) * second_difference;
  }
  return static_cast<double>(sum);
}

std::vector<double> RandomWalk(std::size_t count) {
  std::mt19937_64 random(20120709);
  std::normal_distribution<double> step(0, 1e-4);
  std::vector<double> positions = {0.25};
  while (positions.size() < count) {
    positions.push_back(positions.back() + step(random));
  }
  return positions;
}

TEST(AccelerationEstimatorTest, FollowsEquations3And4OnARandomMotion) {
  const std::vector<double> positions = RandomWalk(300);
  AccelerationEstimator estimator(kPeriodS, kCutoffHz);
  for (std::size_t k = 0; k < positions.size(); ++k) {
    const double expected = AccelerationBySum(positions, k);
    EXPECT_NEAR(estimator.Update(positions[k]), expected, 1e-8) << "tick " << k;
  }
}

TEST(AccelerationEstimatorTest, HasTheFrequencyResponseOfHTimesD) {
  const double angle = 2 * std::numbers::pi * 37 * kPeriodS;
  const std::complex<double> z = std::polar(1.0, angle);
  const double a = std::exp(-2 * std::numbers::pi * kCutoffHz * kPeriodS);
  const std::complex<double> response =
      (1 - a) * z / (z - a) * (z - 1.0) * (z - 1.0) / (kPeriodS * kPeriodS * z * z);
  AccelerationEstimator estimator(kPeriodS, kCutoffHz);
  double acceleration = 0;
  int k = 0;
  for (; k < 2000; ++k) {
    acceleration = estimator.Update(std::cos(angle * k));
  }
  const double expected = (response * std::polar(1.0, angle * (k - 1))).real();
  EXPECT_NEAR(acceleration, expected, 1e-9 * std::abs(response));
}

// One of every kind.
std::vector<AccelerationEstimator> OneOfEach() {
  std::vector<AccelerationEstimator> estimators;
  for (const EstimatorKind kind : kEstimatorKinds) {
    estimators.emplace_back(kPeriodS, kCutoffHz, kind);
  }
  return estimators;
}

TEST(AccelerationEstimatorTest, SettlesOnAConstantAcceleration) {
  for (AccelerationEstimator& estimator : OneOfEach()) {
    for (int k = 0; k < 1000; ++k) {
      const double t = k * kPeriodS;
      estimator.Update(0.5 * 3.0 * t * t);
    }
    EXPECT_NEAR(estimator.acceleration(), 3.0, 1e-6);
    EXPECT_NEAR(estimator.velocity(), 3.0 * 998.5 * kPeriodS, 1e-9);
  }
}

TEST(AccelerationEstimatorTest, SeesNoStepAtTheFirstPositionOrAfterAReset) {
  for (AccelerationEstimator& estimator : OneOfEach()) {
    EXPECT_EQ(estimator.Update(1.5), 0);
    EXPECT_EQ(estimator.velocity(), 0);
    EXPECT_EQ(estimator.Update(1.5), 0);
    estimator.Update(1.6);
    estimator.Update(1.6);
    EXPECT_NE(estimator.acceleration(), 0);
    estimator.Reset(-7);
    EXPECT_EQ(estimator.acceleration(), 0);
    EXPECT_EQ(estimator.Update(-7), 0);
    EXPECT_EQ(estimator.Update(-7), 0);
    EXPECT_EQ(estimator.velocity(), 0);
  }
}

TEST(AccelerationEstimatorTest, BridgesAGapAsIfTheMissedPositionsLayOnALine) {
  const std::vector<double> before = RandomWalk(50);
  for (const uint64_t periods : {uint64_t{2}, uint64_t{5}, AccelerationEstimator::kMaxBridgedPeriods}) {
    for (AccelerationEstimator& whole : OneOfEach()) {
      for (const double position : before) {
        whole.Update(position);
      }
      AccelerationEstimator gapped = whole;
      const double start = before.back();
      const double end = start + 0.01;
      for (uint64_t i = 1; i <= periods; ++i) {
        whole.Update(start + (end - start) * static_cast<double>(i) / static_cast<double>(periods));
      }
      gapped.Update(end, periods);
      EXPECT_NEAR(gapped.acceleration(), whole.acceleration(), 1e-6);
      EXPECT_NEAR(gapped.velocity(), whole.velocity(), 1e-9);
    }
  }
}

TEST(AccelerationEstimatorTest, SeesNoAccelerationAcrossAGapInASteadyMotion) {
  for (AccelerationEstimator& estimator : OneOfEach()) {
    estimator.Reset(0);
    int k = 1;
    for (; k < 2000; ++k) {
      estimator.Update(k * 0.0005);
    }
    ASSERT_NEAR(estimator.acceleration(), 0, 1e-6);
    EXPECT_NEAR(estimator.Update((k + 3) * 0.0005, 4), 0, 1e-6);
  }
}

TEST(AccelerationEstimatorTest, StartsAfreshAfterAGapTooLongToBridge) {
  for (AccelerationEstimator& estimator : OneOfEach()) {
    estimator.Update(0);
    estimator.Update(0.1);
    EXPECT_EQ(estimator.Update(9, AccelerationEstimator::kMaxBridgedPeriods + 1), 0);
    EXPECT_EQ(estimator.velocity(), 0);
  }
}

TEST(AccelerationEstimatorTest, GivesTheSameBitsFromTheSamePositions) {
  for (AccelerationEstimator& first : OneOfEach()) {
    AccelerationEstimator second = first;
    for (const double position : RandomWalk(1000)) {
      first.Update(position);
      second.Update(position);
      ASSERT_EQ(std::bit_cast<uint64_t>(first.acceleration()),
                std::bit_cast<uint64_t>(second.acceleration()));
    }
  }
}

TEST(AccelerationEstimatorTest, ChangesIntoAnotherWithoutAJumpUnderAConstantAcceleration) {
  for (const AccelerationEstimator& fresh : OneOfEach()) {
    for (const EstimatorKind to : kEstimatorKinds) {
      AccelerationEstimator estimator = fresh;
      const auto position = [](int k) { return 1.5 * k * kPeriodS * k * kPeriodS; };
      int k = 0;
      for (; k < 2000; ++k) {
        estimator.Update(position(k));
      }
      const AccelerationEstimator changed = estimator.ChangedTo(to, 37);
      EXPECT_EQ(changed.position(), estimator.position());
      EXPECT_EQ(changed.velocity(), estimator.velocity());
      EXPECT_EQ(changed.acceleration(), estimator.acceleration());
      AccelerationEstimator running = changed;
      for (; k < 2200; ++k) {
        ASSERT_NEAR(running.Update(position(k)), 3, 1e-6) << Name(to);
      }
    }
  }
}

TEST(AccelerationEstimatorTest, RunsLikeTheOneThatItChangedInto) {
  const std::vector<double> positions = RandomWalk(4000);
  for (const AccelerationEstimator& fresh : OneOfEach()) {
    for (const EstimatorKind to : kEstimatorKinds) {
      AccelerationEstimator changed = fresh;
      AccelerationEstimator always(kPeriodS, 37, to);
      for (std::size_t k = 0; k < positions.size(); ++k) {
        if (k == 1000) {
          changed = changed.ChangedTo(to, 37);
        }
        changed.Update(positions[k]);
        always.Update(positions[k]);
      }
      EXPECT_NEAR(changed.acceleration(), always.acceleration(), 1e-9) << Name(to);
    }
  }
}

TEST(AccelerationEstimatorTest, RestoredFromItsMemoryGoesOnBitForBit) {
  const std::vector<double> positions = RandomWalk(2000);
  std::vector<EstimatorKind> kinds(kEstimatorKinds.begin(), kEstimatorKinds.end());
  kinds.insert(kinds.end(), kAccelerometerKinds.begin(), kAccelerometerKinds.end());
  std::mt19937_64 random(7);
  std::uniform_int_distribution<int> one_of_fifty(0, 49);
  for (const EstimatorKind from : kinds) {
    for (const EstimatorKind to : kinds) {
      AccelerationEstimator running(kPeriodS, kCutoffHz, from);
      AccelerationEstimator restored(kPeriodS, kCutoffHz, from);
      EXPECT_FALSE(running.Memory().primed);
      for (std::size_t k = 0; k < positions.size(); ++k) {
        if (k == 1000) {
          running = running.ChangedTo(to, 37);
          restored = AccelerationEstimator(kPeriodS, 37, to);
          restored.Restore(running.Memory());
        }
        if (one_of_fifty(random) == 0) {
          restored = k < 1000 ? AccelerationEstimator(kPeriodS, kCutoffHz, from)
                              : AccelerationEstimator(kPeriodS, 37, to);
          restored.Restore(running.Memory());
        }
        const uint64_t periods = one_of_fifty(random) == 0 ? 5 : 1;
        const double sensed = 100 * positions[k];
        const double expected = running.Update(positions[k], periods, sensed);
        ASSERT_EQ(std::bit_cast<uint64_t>(restored.Update(positions[k], periods, sensed)),
                  std::bit_cast<uint64_t>(expected))
            << Name(from) << " to " << Name(to) << " at " << k;
        ASSERT_EQ(restored.velocity(), running.velocity());
        ASSERT_EQ(restored.Memory().low_pass, running.Memory().low_pass);
      }
      EXPECT_TRUE(restored.Memory().primed);
    }
  }
}

TEST(AccelerationEstimatorTest, ThatHasSeenNothingTakesTheFirstPositionAsRestAlsoOnceChanged) {
  AccelerationEstimator changed =
      AccelerationEstimator(kPeriodS, kCutoffHz).ChangedTo(EstimatorKind::kKalman, 20);
  EXPECT_EQ(changed.Update(0.4), 0);
  EXPECT_EQ(changed.velocity(), 0);
}

}  // namespace
}  // namespace mwidth::model
