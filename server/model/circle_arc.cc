#include "server/model/circle_arc.h"

#include <cstddef>

namespace mwidth::model {
namespace {

double& At(ArcForm& form, int i) noexcept { return form.coefficients[static_cast<std::size_t>(i)]; }
double At(const ArcForm& form, int i) noexcept { return form.coefficients[static_cast<std::size_t>(i)]; }

// (1-x) + x = 1 is a factor of any form.
ArcForm RaiseDegree(ArcForm form, int degree) noexcept {
  for (; form.degree < degree; ++form.degree) {
    for (int i = form.degree + 1; i > 0; --i) {
      At(form, i) += At(form, i - 1);
    }
  }
  return form;
}

// u = 2 - 2 cos t = 4 s.
ArcForm U(const Arc& arc) noexcept { return LinearForm(4 * arc.low, 4 * arc.high); }

}  // namespace

ArcForm ConstantForm(double value) noexcept { return {.coefficients = {value}, .degree = 0}; }

ArcForm LinearForm(double at_low, double at_high) noexcept {
  return {.coefficients = {at_low, at_high}, .degree = 1};
}

double Evaluate(const ArcForm& form, double x) noexcept {
  return Evaluate(form.coefficients, form.degree, PointAt(x));
}

ArcForm Derivative(const ArcForm& form) noexcept {
  ArcForm slope;
  slope.degree = form.degree - 1;
  for (int i = 0; i < form.degree; ++i) {
    At(slope, i) = (i + 1) * At(form, i + 1) - (form.degree - i) * At(form, i);
  }
  return slope;
}

ArcForm Multiply(const ArcForm& a, const ArcForm& b) noexcept {
  ArcForm product;
  if (a.degree < 0 || b.degree < 0) {
    return product;
  }
  product.degree = a.degree + b.degree;
  for (int i = 0; i <= a.degree; ++i) {
    for (int k = 0; k <= b.degree; ++k) {
      At(product, i + k) += At(a, i) * At(b, k);
    }
  }
  return product;
}

ArcForm Add(const ArcForm& a, double factor, const ArcForm& b) noexcept {
  ArcForm sum = RaiseDegree(a, b.degree);
  const ArcForm other = RaiseDegree(b, a.degree);
  for (int i = 0; i <= sum.degree; ++i) {
    At(sum, i) += factor * At(other, i);
  }
  return sum;
}

RootBrackets IsolateRoots(const ArcForm& form) noexcept {
  Form bernstein{};
  double binomial = 1;
  for (int i = 0; i <= form.degree; ++i) {
    bernstein[static_cast<std::size_t>(i)] = At(form, i) / binomial;
    binomial = binomial * (form.degree - i) / (i + 1);
  }
  return IsolateRoots({bernstein.data(), static_cast<std::size_t>(form.degree) + 1});
}

ComplexArcForm Conjugate(const ComplexArcForm& a) noexcept { return {.re = a.re, .im = Add({}, -1, a.im)}; }

ComplexArcForm Multiply(const ComplexArcForm& a, const ComplexArcForm& b, const Arc& arc) noexcept {
  // sin^2(t) = 4 s c
  const ArcForm sine_squared = Multiply(U(arc), LinearForm(1 - arc.low, 1 - arc.high));
  return {.re = Add(Multiply(a.re, b.re), -1, Multiply(sine_squared, Multiply(a.im, b.im))),
          .im = Add(Multiply(a.re, b.im), 1, Multiply(a.im, b.re))};
}

// Horner's rule; w = -2 s + j sin t.
ComplexArcForm OnArc(const DifferencePolynomial& polynomial, const Arc& arc) {
  const ComplexArcForm w{.re = LinearForm(-2 * arc.low, -2 * arc.high), .im = ConstantForm(1)};
  ComplexArcForm value{.re = ConstantForm(polynomial.back()), .im = {}};
  for (std::size_t k = polynomial.size() - 1; k-- > 0;) {
    value = Multiply(value, w, arc);
    value.re = Add(value.re, polynomial[k], ConstantForm(1));
  }
  return value;
}

// |p|^2 = sum of p_i^2 u^i + sum over i < k of p_i p_k u^i T_(k-i), where T_n = w^n + conj(w)^n: 2, -u, and
// T_(n+1) = -u (T_n + T_(n-1)) from there on.
ArcForm SizeSquared(const DifferencePolynomial& polynomial, const Arc& arc) {
  const ArcForm u = U(arc);
  const std::size_t count = polynomial.size();
  ArcForm size;
  ArcForm before = ConstantForm(2);
  ArcForm twice_re = Add({}, -1, u);
  for (std::size_t apart = 0; apart < count; ++apart) {
    // sum of p_i p_(i+apart) u^i
    ArcForm sum;
    for (std::size_t i = count - apart; i-- > 0;) {
      sum = Add(ConstantForm(polynomial[i] * polynomial[i + apart]), 1, Multiply(u, sum));
    }
    if (apart == 0) {
      size = sum;
      continue;
    }
    size = Add(size, 1, Multiply(sum, twice_re));
    const ArcForm next = Add({}, -1, Multiply(u, Add(twice_re, 1, before)));
    before = twice_re;
    twice_re = next;
  }
  return size;
}

}  // namespace mwidth::model
