#include "server/model/unit_circle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

namespace mwidth::model {
namespace {

constexpr double kPi = 3.14159265358979323846;

// A product of four: 1/z, conj(w + gap), 1/z once more, and a factor that turns the other way.
constexpr double kGap = 0.3;
constexpr CircleFactor kFilter{kGap, kGap - 2, 1};
constexpr CircleFactor kOther{0.7, 1.9, -0.6};

std::complex<double> Expected(double angle) {
  const std::complex<double> z = std::polar(1.0, angle);
  const double c = (1 + std::cos(angle)) / 2;
  const double s = (1 - std::cos(angle)) / 2;
  return std::conj(z) * std::conj(z - 1.0 + kGap) * std::conj(z) *
         std::complex<double>(0.7 * c + 1.9 * s, 0.6 * std::sin(angle));
}

TEST(UnitCircle, ValuesAndFormsEqualComplexArithmetic) {
  CircleForm form;
  form.degree = 1;
  form.re = {1, -1};
  form.im = {-1};
  for (const CircleFactor& factor : {kFilter, kOneTickLater, kOther}) {
    form = Times(form, factor);
  }
  ASSERT_EQ(form.degree, 4);
  for (int i = 0; i <= 100; ++i) {
    const double angle = kPi * i / 100;
    const double half_sine = std::sin(angle / 2);
    const CirclePoint at = PointAt(half_sine * half_sine);
    const std::complex<double> expected = Expected(angle);

    CircleValue value{at.c - at.s, -1, 1, 1};
    for (const CircleFactor& factor : {kFilter, kOneTickLater, kOther}) {
      value = Times(value, factor, at);
    }
    EXPECT_NEAR(value.re, expected.real(), 1e-14);
    EXPECT_NEAR(value.im * std::sin(angle), expected.imag(), 1e-14);
    EXPECT_GE(value.re_size, std::abs(value.re));
    EXPECT_GE(value.im_size, std::abs(value.im));

    EXPECT_NEAR(Evaluate(form.re, form.degree, at), value.re, 1e-14);
    EXPECT_NEAR(Evaluate(form.im, form.degree - 1, at), value.im, 1e-14);
  }
}

TEST(UnitCircle, KeepsTheRelativeAccuracyOfASmallGapAtBothEnds) {
  // conj(w + gap) at |w| = 2e-12: the real part is gap - 2 s, of 1e-20, and not the difference of two numbers
  // near 1. At the other end of the circle it is the same the other way round.
  const CirclePoint at = PointAt(1e-24);
  const CircleValue value = Times({1, 0, 1, 0}, {1e-20, 1e-20 - 2, 1}, at);
  EXPECT_DOUBLE_EQ(value.re, 0.9998e-20);
  EXPECT_DOUBLE_EQ(value.im, -1);
  const CircleValue opposite = Times({1, 0, 1, 0}, {-2, 1e-20, 1}, {1, 1e-24});
  EXPECT_DOUBLE_EQ(opposite.re, 0.9998e-20);
}

}  // namespace
}  // namespace mwidth::model
