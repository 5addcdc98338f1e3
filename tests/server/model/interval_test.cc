#include "server/model/interval.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/server/model/reference_plant.h"

namespace mwidth::model {
namespace {

testing::AssertionResult Holds(const Interval& interval, const Real& value) {
  if (interval.lo <= value && value <= interval.hi) {
    return testing::AssertionSuccess();
  }
  return testing::AssertionFailure() << value << " is not in " << interval.lo << " .. " << interval.hi;
}

class IntervalTest : public testing::Test {
 protected:
  double Uniform(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }
  // Of any sign and size, also a point, also with 0 inside.
  Interval Any() {
    const double first = std::copysign(std::exp(Uniform(-30, 5)), Uniform(-1, 1));
    const double width = Uniform(0, 1) < 0.3 ? 0 : std::exp(Uniform(-35, 5));
    return {first, first + width};
  }
  Interval AnyPositive() {
    const double first = std::exp(Uniform(-30, 5));
    return {first, first * std::exp(Uniform(0, 1) < 0.3 ? 0 : Uniform(0, 3))};
  }
  Real Inside(const Interval& a) {
    const double way = Uniform(0, 1);
    return way < 0.2   ? Real(a.lo)
           : way < 0.4 ? Real(a.hi)
                       : Real(a.lo) + Real(Uniform(0, 1)) * (Real(a.hi) - a.lo);
  }

  std::mt19937_64 random_{1};
};

TEST_F(IntervalTest, OperationsHoldEveryExactResult) {
  for (int i = 0; i < 20000; ++i) {
    const Interval a = Any();
    const Interval b = Any();
    const Interval positive = AnyPositive();
    const Real x = Inside(a);
    const Real y = Inside(b);
    const Real p = Inside(positive);
    ASSERT_TRUE(Holds(a + b, x + y));
    ASSERT_TRUE(Holds(a - b, x - y));
    ASSERT_TRUE(Holds(a * b, x * y));
    ASSERT_TRUE(Holds(a / positive, x / p));
    ASSERT_TRUE(Holds(b.lo * a, Real(b.lo) * x));
    ASSERT_TRUE(Holds(Square(a), x * x));
    ASSERT_TRUE(Holds(Sqrt(positive), sqrt(p)));
  }
}

TEST_F(IntervalTest, FunctionsHoldEveryExactResult) {
  for (int i = 0; i < 20000; ++i) {
    const Interval a = Any();
    const Interval positive = AnyPositive();
    const Real x = Inside(a);
    const Real p = Inside(positive);
    ASSERT_TRUE(Holds(Exp(a), exp(x)));
    ASSERT_TRUE(Holds(Sin(a), sin(x))) << a.lo << " " << a.hi;
    ASSERT_TRUE(Holds(Cos(a), cos(x))) << a.lo << " " << a.hi;
    ASSERT_TRUE(Holds(MeanDecay(positive), (1 - exp(-p)) / p));
  }
}

TEST_F(IntervalTest, FunctionsOfAPointAreNarrow) {
  for (int i = 0; i < 1000; ++i) {
    const double x = Uniform(-3, 3);
    EXPECT_LT(Exp(Exactly(x)).width(), 1e-14 * std::exp(x));
    EXPECT_LT(MeanDecay(Exactly(std::abs(x))).width(), 1e-14);
    EXPECT_LT(Sin(Exactly(x)).width(), 1e-14);
  }
}

TEST_F(IntervalTest, OscillationsPassTheirExtremaInside) {
  const double pi = std::numbers::pi;
  EXPECT_EQ(Sin({1, 2}).hi, 1);
  EXPECT_EQ(Cos({3, 4}).lo, -1);
  EXPECT_LT(Cos({3, 4}).hi, 0);
  EXPECT_EQ(Cos({-0.1, 0.1}).hi, 1);
  EXPECT_EQ(Sin({pi, 2 * pi}).lo, -1);
  EXPECT_EQ(Cos({0, 7}).lo, -1);
  EXPECT_EQ(Cos({0, 7}).hi, 1);
}

}  // namespace
}  // namespace mwidth::model
