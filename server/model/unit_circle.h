// Arithmetic on the unit circle z = e^(jt), written with half angles so that nothing cancels near z = 1.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "server/model/real_roots.h"

namespace mwidth::model {

/// z = e^(jt) by s = sin^2(t/2) and c = cos^2(t/2): |z - 1|^2 = 4 s, Re z = c - s, sin^2(t) = 4 s c.
struct CirclePoint {
  double s = 0;
  double c = 1;
};

inline CirclePoint PointAt(double half_sine_squared) noexcept {
  return {half_sine_squared, 1 - half_sine_squared};
}

/// The angle t, 0 to pi. Rt.
inline double AngleAt(double half_sine_squared) noexcept {
  // The arc sine of what is small, sine or cosine: as exact as atan2 of both at a third of its cost.
  return half_sine_squared <= 0.5 ? 2 * std::asin(std::sqrt(half_sine_squared))
                                  : std::numbers::pi - 2 * std::asin(std::sqrt(1 - half_sine_squared));
}

/// The frequency of z = e^(jt) in Hz. Rt.
inline double FrequencyHz(double half_sine_squared, double period_s) noexcept {
  return AngleAt(half_sine_squared) / (2 * std::numbers::pi * period_s);
}

/// The complex number re + j sin(t) im, with the sizes that re and im would have if nothing cancelled: the
/// rounding error of each is a few units in the last place of its size.
struct CircleValue {
  double re = 0;
  double im = 0;
  double re_size = 0;
  double im_size = 0;
};

/// at_c c + at_s s - j turn sin(t): what a product is made of. Accurate near z = 1 and z = -1 alike.
struct CircleFactor {
  double at_c = 0;
  double at_s = 0;
  double turn = 0;
};

/// conj(z) = cos t - j sin(t).
inline constexpr CircleFactor kOneTickLater{1, -1, 1};

/// value times factor. Rt.
inline CircleValue Times(const CircleValue& value, const CircleFactor& factor,
                         const CirclePoint& at) noexcept {
  const double real = factor.at_c * at.c + factor.at_s * at.s;
  const double real_size = std::abs(factor.at_c) * at.c + std::abs(factor.at_s) * at.s;
  const double turn_size = std::abs(factor.turn);
  const double sine_squared = 4 * at.s * at.c;
  return {value.re * real + sine_squared * factor.turn * value.im, value.im * real - factor.turn * value.re,
          value.re_size * real_size + sine_squared * turn_size * value.im_size,
          value.im_size * real_size + turn_size * value.re_size};
}

/// A real polynomial in c and s, homogeneous: sum over i of form[i] c^(degree - i) s^i. Every polynomial in
/// cos t has this shape because c + s = 1; its coefficients near t = 0 stay exact where powers of cos t would
/// cancel.
using Form = std::array<double, kMaxRootDegree + 1>;

/// Value of a form. Rt.
inline double Evaluate(const Form& form, int degree, const CirclePoint& at) noexcept {
  double value = form[0];
  double power = 1;
  for (int i = 1; i <= degree; ++i) {
    power *= at.s;
    value = value * at.c + form[static_cast<size_t>(i)] * power;
  }
  return value;
}

/// re + j sin(t) im, all along the circle: re is of degree `degree`, im of one less.
struct CircleForm {
  Form re{};
  Form im{};
  int degree = 0;
};

/// form times factor. Precondition: form.degree < kMaxRootDegree. Rt.
inline CircleForm Times(const CircleForm& form, const CircleFactor& factor) noexcept {
  CircleForm product;
  product.degree = form.degree + 1;
  for (int k = 0; k <= product.degree; ++k) {
    const auto i = static_cast<size_t>(k);
    const double re = k <= form.degree ? form.re[i] : 0;
    const double re_before = k > 0 ? form.re[i - 1] : 0;
    const double im = k < form.degree ? form.im[i] : 0;
    const double im_before = k > 0 ? form.im[i - 1] : 0;
    product.re[i] = factor.at_c * re + factor.at_s * re_before + factor.turn * 4 * im_before;
    product.im[i] = factor.at_c * im + factor.at_s * im_before - factor.turn * re;
  }
  return product;
}

}  // namespace mwidth::model
