#include "server/model/real_roots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

namespace mwidth::model {
namespace {

// The polynomial with the given real roots and pairs of complex ones, by its Bernstein coefficients and its
// factors.
class Polynomial {
 public:
  struct Pair {
    double centre;
    double half_width;  // the roots are centre +- j half_width
  };

  Polynomial(std::vector<double> roots, std::vector<Pair> pairs)
      : roots_(std::move(roots)), pairs_(std::move(pairs)) {
    for (const double root : roots_) {
      Multiply({-root, 1 - root});
    }
    for (const Pair& pair : pairs_) {
      const double size = pair.centre * pair.centre + pair.half_width * pair.half_width;
      // (x - centre)^2 + half_width^2 in powers of x and 1 - x.
      Multiply({size, 2 * size - 2 * pair.centre, size - 2 * pair.centre + 1});
    }
  }

  std::vector<double> Bernstein() const {
    std::vector<double> result = scaled_;
    double binomial = 1;
    for (size_t i = 0; i < result.size(); ++i) {
      result[i] /= binomial;
      binomial = binomial * static_cast<double>(result.size() - 1 - i) / static_cast<double>(i + 1);
    }
    return result;
  }

  ValueAndSlope operator()(double x) const {
    ValueAndSlope result{1, 0};
    for (const double root : roots_) {
      result.slope = result.slope * (x - root) + result.value;
      result.value *= x - root;
    }
    for (const Pair& pair : pairs_) {
      const double offset = x - pair.centre;
      const double factor = offset * offset + pair.half_width * pair.half_width;
      result.slope = result.slope * factor + result.value * 2 * offset;
      result.value *= factor;
    }
    return result;
  }

 private:
  void Multiply(const std::vector<double>& factor) {
    std::vector<double> product(scaled_.size() + factor.size() - 1, 0);
    for (size_t i = 0; i < scaled_.size(); ++i) {
      for (size_t k = 0; k < factor.size(); ++k) {
        product[i + k] += scaled_[i] * factor[k];
      }
    }
    scaled_ = product;
  }

  std::vector<double> roots_;
  std::vector<Pair> pairs_;
  std::vector<double> scaled_{1};  // coefficients of x^i (1-x)^(n-i)
};

std::vector<double> Roots(const Polynomial& polynomial) {
  const std::vector<double> bernstein = polynomial.Bernstein();
  std::vector<double> found;
  for (const RootBracket& bracket : IsolateRoots(bernstein)) {
    found.push_back(RefineRoot(bracket, polynomial));
  }
  return found;
}

void ExpectRoots(const std::vector<double>& found, std::vector<double> expected) {
  std::sort(expected.begin(), expected.end());
  ASSERT_EQ(found.size(), expected.size());
  for (size_t i = 0; i < found.size(); ++i) {
    EXPECT_NEAR(found[i], expected[i], 1e-14 * expected[i]);
  }
}

TEST(RealRoots, FindsEveryRootHoweverSmall) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> exponent(-12, 0);
  for (int i = 0; i < 2000; ++i) {
    std::vector<double> roots;
    for (int k = 0; k <= i % 6; ++k) {
      roots.push_back(std::pow(10, exponent(random)));
    }
    ExpectRoots(Roots(Polynomial(roots, {})), roots);
  }
}

TEST(RealRoots, TellsCloseRootsFromAComplexPairBesideTheAxis) {
  ExpectRoots(Roots(Polynomial({0.3, 0.3 + 1e-6, 0.9}, {})), {0.3, 0.3 + 1e-6, 0.9});
  ExpectRoots(Roots(Polynomial({0.9}, {{0.3, 1e-6}})), {0.9});
  ExpectRoots(Roots(Polynomial({1e-9}, {{2e-9, 1e-12}, {0.5, 1e-3}})), {1e-9});
}

TEST(RealRoots, LeavesOutWhatLiesOutside) {
  ExpectRoots(Roots(Polynomial({-0.1, 1.1, 0.5, 7}, {})), {0.5});
  ExpectRoots(Roots(Polynomial({-0.1, 1.1}, {{0.5, 0.1}})), {});
}

TEST(RealRoots, ReportsADoubleRoot) {
  // Exact in binary, so that not a sign is lost to rounding.
  const std::vector<double> found = Roots(Polynomial({0.375, 0.375, 0.75}, {}));
  ASSERT_GE(found.size(), 2U);
  EXPECT_NEAR(found.front(), 0.375, 1e-7);
  EXPECT_NEAR(found.back(), 0.75, 1e-14);
}

TEST(RealRoots, FindsARootWhereTheIntervalIsHalved) {
  ExpectRoots(Roots(Polynomial({0.25, 0.5, 0.75}, {})), {0.25, 0.5, 0.75});
  ExpectRoots(Roots(Polynomial({0.5}, {})), {0.5});
}

TEST(RealRoots, AreRefinedInAFewStepsAlsoWhereTheLastOneIsTooSmallToTake) {
  // Where the values are rounded, an iteration ends on either side of a root, as often as not one step too
  // small to move it away; halving the rest of the bracket would take another fifty.
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(0.1, 0.9);
  for (int i = 0; i < 1000; ++i) {
    const double root = uniform(random);
    int evaluations = 0;
    const double found =
        RefineRoot({.low = 0, .high = 1, .rising = true, .guess = uniform(random)}, [&](double x) {
          ++evaluations;
          const double away = x - root;
          return ValueAndSlope{away + away * away * away / 2 + 1e-17, 1 + 1.5 * away * away};
        });
    EXPECT_NEAR(found, root, 1e-15);
    EXPECT_LE(evaluations, 8);
  }
}

TEST(RealRoots, OfAConstantAreNone) { EXPECT_EQ(IsolateRoots(std::vector<double>{1}).count, 0); }

}  // namespace
}  // namespace mwidth::model
