#include "server/model/level_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

namespace mwidth::model {
namespace {

// top = height * width^2 and bottom = (s - centre)^2 + width^2: a peak of `height` at `centre`.
struct Resonance {
  double centre;
  double width;
  double height;
};

std::vector<OpenLoopOnArc> OnArcs(const Resonance& resonance, const std::vector<Arc>& arcs) {
  std::vector<OpenLoopOnArc> result;
  for (const Arc& arc : arcs) {
    const ArcForm offset = LinearForm(arc.low - resonance.centre, arc.high - resonance.centre);
    const double square = resonance.width * resonance.width;
    result.push_back({.arc = arc,
                      .top_squared = ConstantForm(resonance.height * square),
                      .bottom_squared = Add(Multiply(offset, offset), square, ConstantForm(1)),
                      .sum_squared = {},
                      .step_squared = {},
                      .imaginary = {}});
  }
  return result;
}

auto QuotientOf(const std::vector<OpenLoopOnArc>& arcs, const Resonance& resonance) {
  const auto value = [resonance](double s) {
    const double square = resonance.width * resonance.width;
    const double offset = s - resonance.centre;
    return SizePair{resonance.height * square, offset * offset + square};
  };
  return SizeQuotient{std::span<const OpenLoopOnArc>(arcs), &OpenLoopOnArc::top_squared,
                      &OpenLoopOnArc::bottom_squared, value};
}

TEST(LevelRoots, LieWhereTheQuotientIsAtTheLevel) {
  const Resonance resonance{.centre = 0.3, .width = 0.01, .height = 5};
  for (const std::vector<Arc>& arcs :
       {std::vector<Arc>{{}}, {{.low = 0, .high = 0.301}, {.low = 0.301, .high = 1}}}) {
    const auto on = OnArcs(resonance, arcs);
    const std::vector<double> roots = LevelRoots(QuotientOf(on, resonance), 1);
    ASSERT_EQ(roots.size(), 2U);
    EXPECT_NEAR(roots[0], 0.28, 1e-14);
    EXPECT_NEAR(roots[1], 0.32, 1e-14);
    EXPECT_TRUE(LevelRoots(QuotientOf(on, resonance), 5.001).empty());
  }
}

TEST(LevelRoots, AreNotLostWhereTwoArcsMeet) {
  // All exact in binary: at level 1 the roots are 1/4 and 3/4.
  const Resonance resonance{.centre = 0.5, .width = 0.125, .height = 5};
  const auto on =
      OnArcs(resonance, {{.low = 0, .high = 0.25}, {.low = 0.25, .high = 0.75}, {.low = 0.75, .high = 1}});
  EXPECT_EQ(LevelRoots(QuotientOf(on, resonance), 1), (std::vector<double>{0.25, 0.75}));
}

TEST(HighestRatio, FindsAPeakHoweverNarrowWithoutAHint) {
  for (const double centre : {1e-9, 1e-4, 0.1, 0.77}) {
    for (const double relative_width : {1.0, 1e-2, 1e-5}) {
      const Resonance resonance{.centre = centre, .width = centre * relative_width, .height = 7};
      // Arcs that become shorter towards the peak, as those of a loop do.
      std::vector<double> ends{0, 1};
      for (double way = 0.125; way > relative_width / 8; way /= 8) {
        ends.push_back(centre * (1 - way));
        ends.push_back(centre * (1 + way));
      }
      std::sort(ends.begin(), ends.end());
      std::vector<Arc> arcs;
      for (std::size_t i = 1; i < ends.size(); ++i) {
        arcs.push_back({.low = ends[i - 1], .high = ends[i]});
      }
      const auto on = OnArcs(resonance, arcs);
      const Peak peak = HighestRatio(QuotientOf(on, resonance), 0, 1e-13);
      EXPECT_NEAR(peak.ratio, 7, 1e-12) << centre << ' ' << relative_width;
      EXPECT_NEAR(peak.half_sine_squared, centre, 1e-6 * resonance.width) << centre << ' ' << relative_width;
    }
  }
}

TEST(HighestRatio, MayLieAtAnEnd) {
  const Resonance below{.centre = 0, .width = 0.1, .height = 2};
  EXPECT_EQ(HighestRatio(QuotientOf(OnArcs(below, {{}}), below), 0.5, 1e-10).half_sine_squared, 0);
  const Resonance above{.centre = 1.5, .width = 0.1, .height = 2};
  const auto on = OnArcs(above, {{}});
  EXPECT_EQ(HighestRatio(QuotientOf(on, above), 0.5, 1e-10).half_sine_squared, 1);
}

}  // namespace
}  // namespace mwidth::model
