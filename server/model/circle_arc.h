// Polynomials along an arc of the unit circle, for what would cancel if it were expanded over all of it.
//
// A resonance of small damping is a narrow dip: of q - u, say, of which the square, q^2 - 2 q u + u^2, keeps
// no digits there. Over an arc around the dip, as a form in the position on that arc, every linear factor is
// given by its values at both ends, which are small there and exact, and so are all products.
#pragma once

#include <vector>

#include "server/model/linear_estimator.h"
#include "server/model/real_roots.h"
#include "server/model/unit_circle.h"

namespace mwidth::model {

/// z = e^(jt) with s = sin^2(t/2) from `low` to `high`; the whole upper half by default. A position x, 0 to
/// 1, on it is s = low + (high - low) x.
struct Arc {
  double low = 0;
  double high = 1;

  double HalfSineSquared(double x) const noexcept { return low + (high - low) * x; }
};

/// A real polynomial in s on an arc: sum over i of coefficients[i] (1-x)^(degree - i) x^i. Zero has degree
/// -1.
struct ArcForm {
  Form coefficients{};
  int degree = -1;
};

/// Degree 0 and 1: by the values at the ends of the arc.
ArcForm ConstantForm(double value) noexcept;
ArcForm LinearForm(double at_low, double at_high) noexcept;

/// Value at the position x.
double Evaluate(const ArcForm& form, double x) noexcept;
/// Derivative by x.
ArcForm Derivative(const ArcForm& form) noexcept;
/// Precondition: the degrees sum to at most kMaxRootDegree.
ArcForm Multiply(const ArcForm& a, const ArcForm& b) noexcept;
/// a + factor b.
ArcForm Add(const ArcForm& a, double factor, const ArcForm& b) noexcept;
/// Brackets of all roots inside the arc, by x, ascending.
RootBrackets IsolateRoots(const ArcForm& form) noexcept;

/// re + j sin(t) im.
struct ComplexArcForm {
  ArcForm re;
  ArcForm im;
};

ComplexArcForm Conjugate(const ComplexArcForm& a) noexcept;
ComplexArcForm Multiply(const ComplexArcForm& a, const ComplexArcForm& b, const Arc& arc) noexcept;

/// p(w) and |p(w)|^2, w = z - 1, for a polynomial with at least one coefficient; the latter of p's degree.
ComplexArcForm OnArc(const DifferencePolynomial& polynomial, const Arc& arc);
ArcForm SizeSquared(const DifferencePolynomial& polynomial, const Arc& arc);

}  // namespace mwidth::model
