// Where the quotient of two sizes of a loop crosses a level along the unit circle, and where it is highest.
#pragma once

#include <cmath>
#include <initializer_list>
#include <span>
#include <vector>

#include "server/model/open_loop.h"
#include "server/model/real_roots.h"

namespace mwidth::model {

/// Two sizes at one point.
struct SizePair {
  double top = 0;
  double bottom = 0;
};

/// A quotient of two sizes: as polynomials, fields of every arc, and unexpanded, s = sin^2(t/2) -> SizePair.
/// The polynomials find the roots, all of them; the unexpanded sizes, which carry less rounding, place them.
template <typename Value>
struct SizeQuotient {
  std::span<const OpenLoopOnArc> arcs;
  ArcForm OpenLoopOnArc::*top;
  ArcForm OpenLoopOnArc::*bottom;
  Value value;
};
// Clang 14 does not deduce aggregates by itself.
template <typename Value>
SizeQuotient(std::span<const OpenLoopOnArc>, ArcForm OpenLoopOnArc::*, ArcForm OpenLoopOnArc::*, Value)
    -> SizeQuotient<Value>;

/// All s in (0, 1) where top = level bottom, ascending. Any thread.
template <typename Value>
std::vector<double> LevelRoots(const SizeQuotient<Value>& quotient, double level) {
  std::vector<double> roots;
  for (const OpenLoopOnArc& on : quotient.arcs) {
    const ArcForm above = Add(on.*quotient.top, -level, on.*quotient.bottom);
    const ArcForm slope = Derivative(above);
    if (on.arc.low > 0 && above.coefficients[0] == 0) {
      roots.push_back(on.arc.low);  // where two arcs meet, neither has it inside
    }
    for (const RootBracket& bracket : IsolateRoots(above)) {
      const double x = RefineRoot(bracket, [&](double at) {
        const SizePair sizes = quotient.value(on.arc.HalfSineSquared(at));
        return ValueAndSlope{sizes.top - level * sizes.bottom, Evaluate(slope, at)};
      });
      roots.push_back(on.arc.HalfSineSquared(x));
    }
  }
  return roots;
}

/// A value of a quotient, and where it is taken.
struct Peak {
  double ratio = 0;
  double half_sine_squared = 0;
};

/// The maximum of top/bottom over 0 <= s <= 1, to the share `tolerance`; bottom > 0. `guess` is a first
/// point.
///
/// A little above the best value so far, by `tolerance`, all roots of top - level bottom are isolated by
/// Descartes' rule. Where there are none, nothing is higher: a proof, but for the rounding of coefficients,
/// and not a search. Otherwise the points between neighbouring roots are better, and each time the distance
/// to the maximum is squared (Boyd and Balakrishnan 1990; Bruinsma and Steinbuch 1990). Any thread.
template <typename Value>
Peak HighestRatio(const SizeQuotient<Value>& quotient, double guess, double tolerance) {
  Peak best;
  const auto try_at = [&](double s) {
    const SizePair sizes = quotient.value(s);
    if (sizes.top > best.ratio * sizes.bottom) {
      best = {.ratio = sizes.top / sizes.bottom, .half_sine_squared = s};
    }
  };
  // Where arcs meet; one more, as these may be zeros of top.
  for (const OpenLoopOnArc& on : quotient.arcs) {
    try_at(on.arc.low);
  }
  for (const double s : {1.0, 1.0 / 3, guess}) {
    try_at(s);
  }
  constexpr int kMaxLevels = 100;
  for (int i = 0; i < kMaxLevels; ++i) {
    const double level = best.ratio * (1 + tolerance);
    double before = 0;
    for (const double root : LevelRoots(quotient, level)) {
      try_at(std::sqrt(before * root));  // frequencies spread over decades: the geometric middle
      before = root;
    }
    if (best.ratio <= level) {
      break;
    }
  }
  return best;
}

}  // namespace mwidth::model
