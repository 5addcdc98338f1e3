#include "server/model/circle_arc.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <cstddef>
#include <random>
#include <vector>

namespace mwidth::model {
namespace {

using Complex = std::complex<double>;

const std::vector<Arc> kArcs{
    {}, {.low = 0.2, .high = 0.7}, {.low = 0, .high = 1e-6}, {.low = 0.9, .high = 1}};

Complex DifferenceAt(double s) { return {-2 * s, 2 * std::sqrt(s * (1 - s))}; }

Complex Value(const ComplexArcForm& form, const Arc& arc, double x) {
  return {Evaluate(form.re, x), Evaluate(form.im, x) * DifferenceAt(arc.HalfSineSquared(x)).imag()};
}

TEST(CircleArc, HoldsThePolynomialsOfAnEstimatorAndTheirProducts) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> coefficient(-1, 1);
  for (const Arc& arc : kArcs) {
    for (std::size_t count = 1; count <= 5; ++count) {
      DifferencePolynomial p(count);
      DifferencePolynomial q(count + 1);
      for (double& c : p) {
        c = coefficient(random);
      }
      for (double& c : q) {
        c = coefficient(random);
      }
      const ComplexArcForm product = Multiply(OnArc(p, arc), Conjugate(OnArc(q, arc)), arc);
      const ArcForm size = SizeSquared(p, arc);
      EXPECT_EQ(size.degree, static_cast<int>(count) - 1);
      EXPECT_EQ(product.re.degree, static_cast<int>(2 * count) - 1);
      EXPECT_EQ(product.im.degree, product.re.degree - 1);
      for (const double x : {0.0, 0.1, 0.5, 0.93, 1.0}) {
        const Complex w = DifferenceAt(arc.HalfSineSquared(x));
        EXPECT_LT(std::abs(Value(product, arc, x) - Evaluate(p, w) * std::conj(Evaluate(q, w))), 1e-12);
        EXPECT_NEAR(Evaluate(size, x), std::norm(Evaluate(p, w)), 1e-12);
      }
    }
  }
}

TEST(CircleArc, KeepsTheDigitsOfANarrowDip) {
  // (s - 0.3)^2 + 1e-20 within 1e-9 of 0.3: expanded over the whole circle no digit would be left.
  const Arc arc{.low = 0.3 - 1e-9, .high = 0.3 + 1e-9};
  const ArcForm offset = LinearForm(arc.low - 0.3, arc.high - 0.3);
  const ArcForm dip = Add(Multiply(offset, offset), 1e-20, ConstantForm(1));
  for (int i = 0; i <= 100; ++i) {
    const double away = arc.low - 0.3 + (arc.high - arc.low) * i / 100;
    const double expected = away * away + 1e-20;
    EXPECT_NEAR(Evaluate(dip, i / 100.0), expected, 1e-14 * 1e-18);
  }
}

TEST(CircleArc, FindsRootsByTheirPositionOnTheArc) {
  const Arc arc{.low = 0.25, .high = 0.75};
  // (s - 0.35) (s - 0.5), and a root outside.
  const auto factor = [&arc](double root) { return LinearForm(arc.low - root, arc.high - root); };
  const ArcForm form = Multiply(Multiply(factor(0.35), factor(0.5)), factor(0.2));
  const ArcForm slope = Derivative(form);
  std::vector<double> found;
  for (const RootBracket& bracket : IsolateRoots(form)) {
    found.push_back(arc.HalfSineSquared(RefineRoot(bracket, [&](double x) {
      return ValueAndSlope{Evaluate(form, x), Evaluate(slope, x)};
    })));
  }
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NEAR(found[0], 0.35, 1e-14);
  EXPECT_NEAR(found[1], 0.5, 1e-14);
}

TEST(CircleArc, ZeroHasNoDegreeAndLeavesOthersTheirs) {
  const ArcForm zero;
  const ArcForm line = LinearForm(1, 2);
  EXPECT_EQ(Multiply(zero, line).degree, -1);
  EXPECT_EQ(Add(zero, 2, line).degree, 1);
  EXPECT_EQ(Evaluate(Add(zero, 2, line), 1), 4);
  EXPECT_EQ(Evaluate(Add(line, 2, zero), 0), 1);
  EXPECT_EQ(Evaluate(zero, 0.5), 0);
  EXPECT_EQ(Derivative(ConstantForm(3)).degree, -1);
}

}  // namespace
}  // namespace mwidth::model
