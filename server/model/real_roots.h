// All real roots of a polynomial in an interval: none missed, none counted twice.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <span>

namespace mwidth::model {

/// Highest degree that IsolateRoots takes.
constexpr int kMaxRootDegree = 15;

/// Part of [0, 1] with exactly one root between `low` and `high`, where the polynomial changes sign; or `low
/// == high` is the root itself (also a double root, as far as double precision can tell).
struct RootBracket {
  double low = 0;
  double high = 0;
  /// True where the polynomial goes from negative to positive.
  bool rising = false;
  /// First approximation.
  double guess = 0;
};

/// As many brackets as a polynomial of the highest degree has roots.
struct RootBrackets {
  std::array<RootBracket, kMaxRootDegree> brackets;
  int count = 0;

  const RootBracket* begin() const { return brackets.data(); }
  const RootBracket* end() const { return brackets.data() + count; }
};

/// Brackets of all roots in (0, 1), ascending, of the polynomial with the given Bernstein coefficients,
/// sum over i of c[i] C(n,i) x^i (1-x)^(n-i). A root at 0 or 1 itself is left out.
///
/// Descartes' rule of signs: no more roots than sign changes in c, exactly one where there is one change;
/// otherwise the interval is halved by de Casteljau's algorithm, which only averages and so keeps the
/// relative accuracy of coefficients of one sign, however small the roots (Collins and Akritas 1976; Lane and
/// Riesenfeld 1981). Precondition: 1 to kMaxRootDegree + 1 finite coefficients. Any thread. Rt.
RootBrackets IsolateRoots(std::span<const double> bernstein) noexcept;

/// Value and slope of a function at a point.
struct ValueAndSlope {
  double value = 0;
  double slope = 0;
};

/// The root in `bracket` of `function` (double -> ValueAndSlope), to the accuracy of its values: Newton's
/// method, bisection where a step would leave the bracket.
template <typename Function>
double RefineRoot(const RootBracket& bracket, const Function& function) noexcept {
  double low = bracket.low;
  double high = bracket.high;
  double x = bracket.guess;
  if (low == high) {
    return low;
  }
  // 200 halvings exhaust any bracket in [0, 1] whose root is above 1e-40.
  for (int i = 0; i < 200; ++i) {
    const ValueAndSlope at = function(x);
    if (at.value == 0) {
      return x;
    }
    ((at.value < 0) == bracket.rising ? low : high) = x;
    const double newton = x - at.value / at.slope;
    // Also a step too small to move x, which is itself an end now. False for NaN.
    const bool inside = (newton > low && newton < high) || newton == x;
    const double next = inside ? newton : low + (high - low) / 2;
    const double step = std::abs(next - x);
    x = next;
    // Newton converges quadratically: after a step this small the next would be below rounding.
    if (step <= (inside ? 1e-10 : 2 * std::numeric_limits<double>::epsilon()) * x) {
      break;
    }
  }
  return x;
}

}  // namespace mwidth::model
