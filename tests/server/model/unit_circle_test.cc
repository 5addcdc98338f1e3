#include "server/model/unit_circle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

namespace mwidth::model {
namespace {

constexpr double kPi = 3.14159265358979323846;

// A product of three conjugate factors: 1/z, w - conj as the filter has it, and 1/z once more.
constexpr double kGap = 0.3;

std::complex<double> Expected(double angle) {
  const std::complex<double> z = std::polar(1.0, angle);
  return std::conj(z) * std::conj(z - 1.0 + kGap) * std::conj(z);
}

TEST(UnitCircle, ValuesAndFormsEqualComplexArithmetic) {
  CircleForm form;
  form.degree = 1;
  form.re = {1, -1};
  form.im = {-1};
  form = TimesConjugate(form, kGap, kGap - 2);
  form = TimesConjugate(form, 1, -1);
  ASSERT_EQ(form.degree, 3);
  for (int i = 0; i <= 100; ++i) {
    const double angle = kPi * i / 100;
    const double half_sine = std::sin(angle / 2);
    const CirclePoint at = PointAt(half_sine * half_sine);
    const std::complex<double> expected = Expected(angle);

    CircleValue value{at.c - at.s, -1, 1, 1};
    value = TimesConjugate(value, kGap - 2 * at.s, kGap + 2 * at.s, at);
    value = TimesConjugate(value, at.c - at.s, 1, at);
    EXPECT_NEAR(value.re, expected.real(), 1e-14);
    EXPECT_NEAR(value.im * std::sin(angle), expected.imag(), 1e-14);
    EXPECT_GE(value.re_size, std::abs(value.re));
    EXPECT_GE(value.im_size, std::abs(value.im));

    EXPECT_NEAR(Evaluate(form.re, form.degree, at), value.re, 1e-14);
    EXPECT_NEAR(Evaluate(form.im, form.degree - 1, at), value.im, 1e-14);
  }
}

TEST(UnitCircle, KeepsTheRelativeAccuracyOfASmallGapNearStandstill) {
  // conj(w + gap) at |w| = 2e-12: the real part is gap - 2 s, of 1e-20, and not the difference of two numbers
  // near 1.
  const CirclePoint at = PointAt(1e-24);
  const CircleValue value = TimesConjugate({1, 0, 1, 0}, 1e-20 - 2 * at.s, 1e-20 + 2 * at.s, at);
  EXPECT_DOUBLE_EQ(value.re, 0.9998e-20);
  EXPECT_DOUBLE_EQ(value.im, -1);
}

}  // namespace
}  // namespace mwidth::model
